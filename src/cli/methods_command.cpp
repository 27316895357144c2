// perp methods: what `perp run --method` may name.
#include "perp/step/methods.hpp"

#include <cstdio>
#include <memory>

#include "cli/commands.hpp"

namespace perp {

void add_methods_command(CLI::App& perp, int& status) {
  CLI::App* command = perp.add_subcommand("methods", "List the methods: name, order, what each does");
  const auto csv = std::make_shared<bool>(false);
  command->add_flag("--csv", *csv, "as CSV: name,order,what");
  command->callback([&status, csv] {
    if (*csv) std::printf("name,order,what\n");
    for (const Method& m : methods()) {
      const std::string name(m.name), what(m.what);
      std::printf(*csv ? "%s,%d,\"%s\"\n" : "%-10s order %d  %s\n", name.c_str(), m.order, what.c_str());
    }
    status = Done;
  });
}

}  // namespace perp
