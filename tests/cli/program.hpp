// The program `perp` as a user's script sees it: arguments in, exit status, standard output and error out.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace perp {

inline std::string contents(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder of the test's own, gone with it.
struct Scratch {
  std::filesystem::path path;
  explicit Scratch(const std::string& name)
      : path(std::filesystem::temp_directory_path() / ("perp-" + name)) {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~Scratch() { std::filesystem::remove_all(path); }
  std::string operator/(const std::string& name) const { return (path / name).string(); }
};

struct Outcome {
  int status = -1;
  std::string out, err;
};

/// Runs `perp ARGUMENTS` in a shell; `before` goes in front of it, for environment variables.
inline Outcome run_perp(const Scratch& scratch, const std::string& arguments,
                        const std::string& before = {}) {
  const std::string out = scratch / "stdout", err = scratch / "stderr";
  const int raw = std::system((before + " " PERP_PROGRAM " " + arguments + " >" + out + " 2>" + err).c_str());
  return {WIFEXITED(raw) ? WEXITSTATUS(raw) : -1, contents(out), contents(err)};
}

/// A CSV file's columns by name, as text.
inline std::map<std::string, std::vector<std::string>> columns(const std::filesystem::path& path) {
  std::map<std::string, std::vector<std::string>> table;
  std::vector<std::string> header;
  std::istringstream file(contents(path));
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line + ",");  // so that a last empty cell counts
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (header.empty()) {
      header = cells;
      for (const std::string& name : header) table[name];
      continue;
    }
    for (std::size_t i = 0; i < header.size() && i < cells.size(); ++i) table[header[i]].push_back(cells[i]);
  }
  return table;
}

}  // namespace perp
