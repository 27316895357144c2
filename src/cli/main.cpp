// The program `perp`: reads the command line, runs the one subcommand it names, turns failures into exit statuses.
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "cli/commands.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

int complain(const char* what, ExitStatus status) {
  std::fprintf(stderr, "perp: %s\n", what);
  return status;
}

int run(int argc, char** argv) {
  CLI::App app{"Rigid bodies with joints and dry friction as complementarity problems", "perp"};
  app.set_version_flag("--version", std::string("perp ") + version);
  app.require_subcommand(0, 1);
  int status = Done;
  add_run_command(app, status);
  add_study_command(app, status);
  add_scenes_command(app, status);
  add_check_command(app, status);
  add_methods_command(app, status);
  add_solve_command(app, status);
  add_generate_command(app, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted_text) {  // --help, --version
    return app.exit(wanted_text);
  } catch (const CLI::ParseError& error) {
    return complain(error.what(), BadInput);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), BadInput);
  } catch (const std::exception& error) {
    return complain(error.what(), InternalError);
  }
  if (app.get_subcommands().empty())
    return complain("a command is required; perp --help lists them", BadInput);
  if (std::fflush(stdout) != 0) return complain("standard output could not be written", InternalError);
  return status;
}

}  // namespace
}  // namespace perp

int main(int argc, char** argv) { return perp::run(argc, argv); }
