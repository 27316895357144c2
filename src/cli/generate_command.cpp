// perp generate: members of a family of contact problems, one file each.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "perp/core/errors.hpp"
#include "perp/solve/friction_io.hpp"
#include "perp/study/friction_families.hpp"

namespace perp {

void add_generate_command(CLI::App& perp, int& status) {
  struct Arguments {
    std::string family, out, format = "text";
    std::uint64_t seed = 0;
    int count = 0, contacts = 0;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = perp.add_subcommand("generate", "Write contact problems of a family, one file each");
  command->add_option("FAMILY", arguments->family, "Which family")
      ->required()
      ->check(CLI::IsMember(friction_families()));
  command->add_option("--seed", arguments->seed, "The same seed gives the same files")
      ->required()
      ->transform(whole_number())
      ->check(CLI::NonNegativeNumber);
  command->add_option("--count", arguments->count, "How many")
      ->required()
      ->transform(whole_number())
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--contacts", arguments->contacts,
                   "Of kapla, pile, chute, torsion, rolling and twist: at most so many a problem")
      ->transform(whole_number())
      ->check(CLI::Range(4, 100'000));
  command->add_option("--out", arguments->out, "Folder to write into")->required()->check(some_text());
  command->add_option("--format", arguments->format, "text or fclib")
      ->check(CLI::IsMember({"text", "fclib"}));
  command->callback([arguments, &status] {
    const Arguments& a = *arguments;
    if (a.contacts > 0 && !takes_contacts(a.family))
      refuse("perp generate", "--contacts", static_cast<double>(a.contacts),
             "needs a family whose size can be chosen, kapla, pile, chute, torsion, rolling or twist: " +
                 a.family + " has its own");
    std::filesystem::create_directories(a.out);
    const bool text = a.format == "text";
    const int digits = std::max<int>(3, static_cast<int>(std::to_string(a.count - 1).size()));
    for (int i = 0; i < a.count; ++i) {
      const std::string number = std::to_string(i);
      const std::string name = a.family + "-" + std::to_string(a.seed) + "-" +
                               std::string(digits - number.size(), '0') + number + (text ? ".dat" : ".hdf5");
      const std::string path = (std::filesystem::path(a.out) / name).string();
      (text ? write_friction_text : write_fclib)(friction_family(a.family, a.seed, i, a.contacts), path);
    }
    status = Done;
  });
}

}  // namespace perp
