// What perp writes to disk goes through here: every call looked at, every refusal said with the system's reason.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace perp {

/// A file that rows are added to. What append() is given arrives whole or not at all, however the disk fills.
/// Throws std::invalid_argument if the file cannot be made, std::runtime_error "writing PATH: REASON" if the disk refuses.
class OutputFile {
 public:
  static constexpr std::uintmax_t everything = UINTMAX_MAX;

  OutputFile() = default;
  /// Opens or makes the file, and its folder, and cuts it to its first `kept` bytes.
  explicit OutputFile(std::filesystem::path path, std::uintmax_t kept = 0);
  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;

  bool open() const { return file_ >= 0; }
  const std::filesystem::path& path() const { return path_; }
  std::uintmax_t size() const { return size_; }

  bool lock();                    ///< for this process alone; false if another has it
  void cut(std::uintmax_t kept);  ///< to its first bytes
  void append(std::string_view rows);
  void sync();              ///< to the disk itself
  void need_there() const;  ///< throws if the file is no longer found under its path
  void close();

 private:
  [[noreturn]] void fail(int reason) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::uintmax_t size_ = 0;
};

/// Writes a file that is whole or the one before it.
void replace_file(const std::filesystem::path& path, std::string_view text);

/// The bytes of a file. Throws std::invalid_argument "PATH: REASON, ALLOWED" if it cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& path, std::string_view allowed);

}  // namespace perp
