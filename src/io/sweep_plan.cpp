#include "io/sweep_plan.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <set>
#include <sstream>

#include "core/files.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"

namespace perp {
namespace {

constexpr const char* as_written = "needs to be as perp study wrote it";

/// SplitMix64 [SLF14]: a number of the place alone, so that shards and jobs draw the same.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

double uniform(std::uint64_t seed, std::uint64_t draw, std::uint64_t axis) {
  const std::uint64_t bits = mixed(mixed(mixed(seed) ^ draw) ^ axis);
  return static_cast<double>(bits >> 11U) * 0x1p-53;
}

long grid_size(const SweepRequest& request) {
  long n = 1;
  constexpr long most = 1'000'000'000;
  for (const SweepAxis& axis : request.axes) {
    if (axis.drawn) continue;
    n *= axis.n;
    if (n > most) refuse("perp study", "--sweep", axis.name, "needs to make 1e9 runs at most");
  }
  return n;
}

template <class Number>
Number number(std::string_view text) {
  Number value{};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size())
    refuse("perp study", "request", text, as_written);
  return value;
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> all;
  for (std::string word; in >> word;) all.push_back(word);
  return all;
}

}  // namespace

void check_sweep(const SweepRequest& request) {
  if (request.scene.empty()) refuse("perp study", "SCENE", "nothing", "needs a scene");
  if (request.methods.empty()) refuse("perp study", "--methods", "nothing", "needs one method or more");
  if (request.axes.empty()) refuse("perp study", "--sweep", "nothing", "needs a parameter or more");
  if (request.ask.empty() && request.pass.empty())
    refuse("perp study", "--ask", "nothing", "needs something to ask of each run, or --pass");
  if (request.draws < 1) refuse("perp study", "--draws", double(request.draws), "needs to be 1 or more");
  const Scene scene = load_scene(request.scene, request.set);
  std::set<std::string> names;
  for (const SweepAxis& axis : request.axes) {
    const bool there = std::any_of(scene.parameters.begin(), scene.parameters.end(),
                                   [&](const SceneParameter& p) { return p.name == axis.name; });
    std::string known;
    for (const SceneParameter& p : scene.parameters) known += (known.empty() ? "" : ", ") + p.name;
    if (!there) refuse("perp study", "--sweep", axis.name, "needs to be a parameter of the scene: " + known);
    if (!names.insert(axis.name).second || request.set.contains(axis.name))
      refuse("perp study", "--sweep", axis.name, "needs to be given once");
    if (!axis.drawn && axis.n < 1) refuse("perp study", "--sweep", double(axis.n), "needs one value or more");
    if (!(axis.low <= axis.high))
      refuse("perp study", "--sweep", axis.name, "needs a lower end no higher than the upper one");
  }
  for (const std::string& name : request.methods)
    if (!method(name).adaptive && request.step.empty())
      refuse("perp study", "--steps", "not given", "method " + name + " needs one step, in seconds or T/N");
  const bool drawn =
      std::any_of(request.axes.begin(), request.axes.end(), [](const SweepAxis& a) { return a.drawn; });
  if (request.draws > 1 && !drawn) refuse("perp study", "--draws", double(request.draws), "needs --draw");
  (void)grid_size(request);
}

long sweep_size(const SweepRequest& request) {
  return grid_size(request) * request.draws * static_cast<long>(request.methods.size());
}

SweepRun sweep_run(const SweepRequest& request, long number) {
  const auto methods = static_cast<long>(request.methods.size());
  SweepRun run{.number = number, .method = static_cast<std::size_t>(number % methods), .values = {}};
  run.values.resize(request.axes.size());
  const long place = number / methods;  // the same numbers for every method
  long rest = place / request.draws;
  for (std::size_t i = request.axes.size(); i-- > 0;) {
    const SweepAxis& axis = request.axes[i];
    if (axis.drawn) {
      const double u = uniform(request.seed, static_cast<std::uint64_t>(place), i);
      run.values[i] = axis.low + (axis.high - axis.low) * u;
      continue;
    }
    const long k = rest % axis.n;
    rest /= axis.n;
    run.values[i] = k + 1 == axis.n && axis.n > 1 ? axis.high
                    : axis.n == 1                 ? axis.low
                                  : axis.low + (axis.high - axis.low) * double(k) / double(axis.n - 1);
  }
  return run;
}

std::string write_sweep_request(const SweepRequest& request) {
  std::string text;
  const auto line = [&](const char* word, const std::string& value) {
    text += std::string(word) + " " + value + "\n";
  };
  line("scene", is_scene_file(request.scene)
                    ? std::filesystem::absolute(request.scene).lexically_normal().string()
                    : request.scene);
  for (const std::string& name : request.methods) line("method", name);
  if (!request.step.empty()) line("step", request.step);
  line("tolerance", shortest(request.tolerance));
  if (!std::isnan(request.until)) line("until", shortest(request.until));
  line("edges", std::to_string(request.edges));
  for (const auto& [key, value] : request.set) line("set", key + " " + shortest(value));
  for (const SweepAxis& axis : request.axes)
    line(axis.drawn ? "draw" : "sweep", axis.name + " " + shortest(axis.low) + " " + shortest(axis.high) +
                                            (axis.drawn ? "" : " " + std::to_string(axis.n)));
  line("draws", std::to_string(request.draws));
  line("seed", std::to_string(request.seed));
  for (const std::string& ask : request.ask) line("ask", ask);
  if (!request.pass.empty()) line("pass", request.pass);
  return text;
}

SweepRequest read_sweep_request(const std::filesystem::path& file) {
  std::istringstream in(read_file(file, as_written));
  SweepRequest request;
  for (std::string text; std::getline(in, text);) {
    const std::size_t space = std::min(text.find(' '), text.size());
    const std::string word = text.substr(0, space), value = text.substr(std::min(space + 1, text.size()));
    const std::vector<std::string> parts = words(value);
    const auto need = [&](std::size_t n) {
      if (parts.size() != n) refuse("perp study", "request", text, as_written);
    };
    if (word == "scene") {
      request.scene = value;
    } else if (word == "method") {
      request.methods.push_back(value);
    } else if (word == "step") {
      request.step = value;
    } else if (word == "tolerance") {
      request.tolerance = number<double>(value);
    } else if (word == "until") {
      request.until = number<double>(value);
    } else if (word == "edges") {
      request.edges = number<int>(value);
    } else if (word == "set") {
      need(2);
      request.set[parts[0]] = number<double>(parts[1]);
    } else if (word == "sweep") {
      need(4);
      request.axes.push_back(
          {parts[0], number<double>(parts[1]), number<double>(parts[2]), number<int>(parts[3])});
    } else if (word == "draw") {
      need(3);
      request.axes.push_back({parts[0], number<double>(parts[1]), number<double>(parts[2]), 1, true});
    } else if (word == "draws") {
      request.draws = number<int>(value);
    } else if (word == "seed") {
      request.seed = number<unsigned long long>(value);
    } else if (word == "ask") {
      request.ask.push_back(value);
    } else if (word == "pass") {
      request.pass = value;
    } else {
      refuse("perp study", "request", text, as_written);
    }
  }
  return request;
}

}  // namespace perp
