#include "io/machine.hpp"

#include <sys/utsname.h>
#include <fstream>
#include <thread>

#include "perp/core/types.hpp"
#include "perp/version.hpp"

#ifdef PERP_HAS_HDF5
#include <H5public.h>
#endif
#ifdef PERP_HAS_SUNDIALS
#include <sundials/sundials_config.h>
#endif
#ifdef PERP_HAS_IPOPT
#include <IpoptConfig.h>
#endif

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

std::string computer() {
  utsname system{};
  uname(&system);
  return processor() + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores; " +
         system.sysname + " " + system.release;
}

std::string build() { return compiler() + ", " + PERP_BUILD_FLAGS; }

std::string machine() { return computer() + "; " + build() + "; perp " + version; }

std::map<std::string, std::string> library_versions() {
  const auto text = [](int a, int b, int c) {
    return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
  };
  std::map<std::string, std::string> versions{
      {"perp", version}, {"eigen", text(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
#ifdef PERP_HAS_HDF5
  versions["hdf5"] = text(H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE);
#endif
#ifdef PERP_HAS_SUNDIALS
  versions["sundials"] = SUNDIALS_VERSION;
#endif
#ifdef PERP_HAS_IPOPT
  versions["ipopt"] = IPOPT_VERSION;
#endif
  return versions;
}

}  // namespace perp
