#include "cli/parameters.hpp"

#include <charconv>

#include "perp/core/errors.hpp"

namespace perp {

SceneParameters read_parameters(const std::string& command, const std::vector<std::string>& pairs) {
  SceneParameters parameters;
  for (const std::string& pair : pairs) {
    const std::size_t equals = pair.find('=');
    double value = 0;
    const char* const end = pair.data() + pair.size();
    const char* const begin = equals == std::string::npos ? end : pair.data() + equals + 1;
    const auto read = std::from_chars(begin, end, value);
    if (equals == 0 || begin == end || read.ec != std::errc() || read.ptr != end)
      refuse(command, "--set", pair, "needs to be KEY=VALUE with a number for VALUE");
    if (!parameters.emplace(pair.substr(0, equals), value).second)
      refuse(command, "--set", pair, "needs to be given once for each KEY");
  }
  return parameters;
}

}  // namespace perp
