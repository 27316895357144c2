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
      const std::string order = m.order > 0 || *csv ? std::to_string(m.order) : "-";
      std::printf(*csv ? "%s,%s,\"%s\"\n" : "%-12s order %s  %s\n", name.c_str(), order.c_str(),
                  what.c_str());
    }
    status = Done;
  });
}

}  // namespace perp
