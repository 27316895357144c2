#include "io/names.hpp"

#include <algorithm>
#include <numeric>

namespace perp {
namespace {

/// Letters to put in, take out or change, to make b of a.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string listed(std::span<const std::string> names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

std::string one_of(std::span<const std::string> names, std::string_view word) {
  constexpr std::size_t long_word = 100;  // nobody meant that
  std::string text = "one of " + listed(names);
  const auto distance = [&](const std::string& name) { return edits(word, name); };
  if (names.empty() || word.size() > long_word) return text;
  const auto nearest =
      std::min_element(names.begin(), names.end(),
                       [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
  if (distance(*nearest) <= std::max<std::size_t>(1, nearest->size() / 3))
    text += " (did you mean " + *nearest + "?)";
  return text;
}

}  // namespace perp
