#include "known_wrong.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace checker {

KnownWrong read_known_wrong(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  KnownWrong known;
  for (std::string line; std::getline(file, line);) {
    if (line.empty()) continue;
    const auto refuse = [&](const std::string& why) {
      throw std::runtime_error(path + ": " + why + ": " + line);
    };
    if (line.starts_with("# ")) {
      const auto colon = line.find(": ");
      if (colon == std::string::npos) refuse("a word for a reason, ': ' and the reason are needed");
      known.reasons[line.substr(2, colon - 2)] = line.substr(colon + 2);
      continue;
    }
    std::istringstream words(line);
    std::uint64_t seed = 0;
    std::string method, reason, more;
    if (!(words >> seed >> method >> reason) || words >> more) refuse("seed, method and a word are needed");
    if (!known.reasons.contains(reason)) refuse("no reason above has this word");
    if (!known.runs.emplace(std::pair(seed, method), reason).second) refuse("there already");
  }
  return known;
}

}  // namespace checker
