#include "core/files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "perp/core/errors.hpp"

namespace perp {

void OutputFile::fail(int reason) const {
  throw std::runtime_error("writing " + path_.string() + ": " +
                           (reason != 0 ? std::strerror(reason) : "the disk took a part only"));
}

OutputFile::OutputFile(std::filesystem::path path, std::uintmax_t kept) : path_(std::move(path)) {
  std::error_code failed;  // opening says it better
  if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path(), failed);
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0)
    refuse("writing", path_.string(), std::strerror(errno), "needs to be a file that can be written");
  try {
    struct stat found {};
    if (fstat(file_, &found) != 0 || !S_ISREG(found.st_mode))
      refuse("writing", path_.string(), "no regular file", "needs to be a file that can be written");
    size_ = static_cast<std::uintmax_t>(found.st_size);
    if (kept != everything && kept > size_)
      refuse("writing", path_.string(), std::to_string(size_) + " bytes long",
             "needs the " + std::to_string(kept) + " that were there");
    if (kept != everything) cut(kept);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)), size_(other.size_) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  std::swap(size_, other.size_);
  return *this;
}

bool OutputFile::lock() {
  if (flock(file_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno != EWOULDBLOCK) fail(errno);
  return false;
}

void OutputFile::cut(std::uintmax_t kept) {
  if (ftruncate(file_, static_cast<off_t>(kept)) != 0) fail(errno);
  size_ = kept;
}

void OutputFile::append(std::string_view rows) {
  for (std::size_t done = 0; done < rows.size();) {
    const ssize_t n = pwrite(file_, rows.data() + done, rows.size() - done, static_cast<off_t>(size_ + done));
    if (n > 0) {
      done += static_cast<std::size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      const int reason = n == 0 ? 0 : errno;
      (void)!ftruncate(file_, static_cast<off_t>(size_));  // rows before these stay whole
      fail(reason);
    }
  }
  size_ += rows.size();
}

void OutputFile::sync() {
  if (fdatasync(file_) != 0) fail(errno);
}

void OutputFile::need_there() const {
  struct stat here {
  }, there{};
  if (fstat(file_, &here) != 0 || stat(path_.c_str(), &there) != 0) fail(errno);
  if (here.st_ino != there.st_ino || here.st_dev != there.st_dev)
    throw std::runtime_error("writing " + path_.string() + ": another file has taken its place");
}

void OutputFile::close() {
  if (::close(std::exchange(file_, -1)) != 0) fail(errno);
}

void replace_file(const std::filesystem::path& path, std::string_view text) {
  OutputFile part(path.string() + ".part");
  part.append(text);
  part.sync();
  part.close();
  std::error_code failed;
  std::filesystem::rename(part.path(), path, failed);
  if (failed) throw std::runtime_error("writing " + path.string() + ": " + failed.message());
}

std::string read_file(const std::filesystem::path& path, std::string_view allowed) {
  const auto fail = [&](int reason) {
    throw std::invalid_argument(path.string() + ": " + std::strerror(reason) + ", " + std::string(allowed));
  };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail(errno);
  std::string text;
  char block[1 << 16];
  for (;;) {
    const ssize_t n = ::read(file, block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int reason = errno;
      ::close(file);
      fail(reason);
    }
    if (n == 0) break;
    text.append(block, static_cast<std::size_t>(n));
  }
  ::close(file);
  return text;
}

}  // namespace perp
