#include "perp/io/csv_file.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "perp/core/errors.hpp"

namespace perp {

CsvFile::CsvFile(std::filesystem::path path, const std::vector<std::string>& header)
    : path_(std::move(path)), part_(path_.string() + ".part") {
  std::error_code failed;
  if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path(), failed);
  file_ = std::fopen(part_.c_str(), "wb");
  if (file_ == nullptr)
    refuse("writing", path_.string(), std::strerror(errno), "needs to be a file that can be written");
  for (const std::string& name : header) cell(name);
  end_row();
}

CsvFile::~CsvFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code ignored;  // nothing more can be done about a leftover
  std::filesystem::remove(part_, ignored);
}

CsvFile& CsvFile::next() {
  if (!first_) buffer_ += ',';
  first_ = false;
  return *this;
}

CsvFile& CsvFile::cell(double value) {
  next();
  if (!std::isnan(value)) buffer_ += shortest(value);
  return *this;
}

CsvFile& CsvFile::cell(int value) {
  next();
  buffer_ += std::to_string(value);
  return *this;
}

CsvFile& CsvFile::cell(std::string_view text) {
  next();
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    buffer_ += text;
    return *this;
  }
  buffer_ += '"';
  for (const char c : text) buffer_.append(c == '"' ? 2 : 1, c);
  buffer_ += '"';
  return *this;
}

void CsvFile::end_row() {
  buffer_ += '\n';
  first_ = true;
  if (buffer_.size() > (1u << 16)) flush();
}

void CsvFile::flush() {
  if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_) != buffer_.size()) {
    throw std::runtime_error("writing " + part_.string() + ": " + std::strerror(errno));
  }
  buffer_.clear();
}

void CsvFile::finish() {
  flush();
  if (std::fclose(std::exchange(file_, nullptr)) != 0) {
    throw std::runtime_error("writing " + part_.string() + ": " + std::strerror(errno));
  }
  std::filesystem::rename(part_, path_);
}

}  // namespace perp
