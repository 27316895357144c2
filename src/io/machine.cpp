#include "io/machine.hpp"

#include <sys/utsname.h>
#include <fstream>
#include <thread>

#include "perp/version.hpp"

#ifndef PERP_BUILD_FLAGS
#define PERP_BUILD_FLAGS "flags not known"
#endif

namespace perp {
namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "processor not known";
}

std::string compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "g++ " __VERSION__;
#else
  return "compiler not known";
#endif
}

}  // namespace

std::string machine() {
  utsname system{};
  uname(&system);
  return processor() + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores; " +
         system.sysname + " " + system.release + "; " + compiler() + ", " + PERP_BUILD_FLAGS + "; perp " +
         version;
}

}  // namespace perp
