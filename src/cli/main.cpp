// The program `perp`: reads the command line, runs the one subcommand it names, turns failures into exit statuses.
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <sstream>
#include <stdexcept>
#include <typeinfo>

#include "cli/commands.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

int complain(const std::string& what, ExitStatus status) {
  std::fprintf(stderr, "perp: %s\n", what.c_str());
  return status;
}

int run(int argc, char** argv) {
  CLI::App app{"Rigid bodies with joints and dry friction as complementarity problems", "perp"};
  app.set_version_flag("--version", std::string("perp ") + version);
  app.require_subcommand(0, 1);
  int status = Done;
  add_run_command(app, {argv, argv + argc}, status);
  add_view_command(app, status);
  add_study_command(app, status);
  add_fit_command(app, status);
  add_scenes_command(app, status);
  add_check_command(app, status);
  add_methods_command(app, status);
  add_solve_command(app, status);
  add_generate_command(app, status);
  add_exam_command(app, status);
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& wanted_text) {  // --help, --version
      std::ostringstream text;
      status = app.exit(wanted_text, text, text);
      std::fputs(text.str().c_str(), stdout);
      need_written(stdout);
      return status;
    }
    if (app.get_subcommands().empty())
      return complain("a command is required; perp --help lists them", BadInput);
    need_written(stdout);
  } catch (const CLI::ParseError& error) {
    return complain(sentence_of(error), BadInput);
  } catch (const std::invalid_argument& error) {
    return complain(sentence_of(error), BadInput);
  } catch (const std::exception& error) {
    return complain(sentence_of(error), InternalError);
  }
  return status;
}

}  // namespace

std::string sentence_of(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return "not enough memory";
  const std::string what = error.what();
  return what.empty() ? std::string("an error of the kind ") + typeid(error).name() : what;
}

void need_written(std::FILE* out) {
  errno = 0;
  if (std::fflush(out) == 0 && std::ferror(out) == 0) return;
  throw std::runtime_error(std::string("standard output could not be written") +
                           (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
}

}  // namespace perp

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its writer, with a name
  return perp::run(argc, argv);
}
