#include "cli/commands.hpp"

namespace perp {

void add_methods_command(CLI::App& perp, int& status) {
  CLI::App* command = perp.add_subcommand("methods", "List the methods: name, order, what each does");
  command->callback([&status] { status = Done; });
}

}  // namespace perp
