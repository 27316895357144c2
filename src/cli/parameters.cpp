#include "cli/parameters.hpp"

#include <charconv>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {

SceneParameters read_parameters(const std::string& command, const std::vector<std::string>& pairs,
                                const std::string& option) {
  SceneParameters parameters;
  for (const std::string& pair : pairs) {
    const std::size_t equals = pair.find('=');
    double value = 0;
    const char* const end = pair.data() + pair.size();
    const char* const begin = equals == std::string::npos ? end : pair.data() + equals + 1;
    const auto read = std::from_chars(begin, end, value);
    if (equals == 0 || begin == end || read.ec != std::errc() || read.ptr != end)
      refuse(command, option, pair, "needs to be KEY=VALUE with a number for VALUE");
    if (!parameters.emplace(pair.substr(0, equals), value).second)
      refuse(command, option, pair, "needs to be given once for each KEY");
  }
  return parameters;
}

CLI::Validator whole_number() {
  return {[](std::string& text) {
            const std::size_t sign = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
            if (text.size() == sign || text.find_first_not_of("0123456789", sign) != std::string::npos)
              return "'" + text + "' is no whole number";
            const std::size_t first = std::min(text.find_first_not_of('0', sign), text.size() - 1);
            text.erase(sign, first - sign);
            if (text.size() > sign + 18) return "'" + text + "' is too large";
            return std::string();
          },
          ""};
}

CLI::Validator finite_number() {
  return {[](std::string& text) {
            double value = 0;
            const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
            const char* const end = text.data() + text.size();
            const auto read = std::from_chars(begin, end, value);
            if (text.empty() || read.ec != std::errc() || read.ptr != end || !std::isfinite(value))
              return "'" + text + "' is no finite number";
            return std::string();
          },
          ""};
}

CLI::Validator some_text() {
  return {[](std::string& text) { return text.empty() ? std::string("is empty") : std::string(); }, ""};
}

}  // namespace perp
