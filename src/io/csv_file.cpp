#include "perp/io/csv_file.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/files.hpp"
#include "perp/core/errors.hpp"

namespace perp {

CsvText& CsvText::next() {
  if (!first_) rows_ += ',';
  first_ = false;
  return *this;
}

CsvText& CsvText::cell(double value) {
  next();
  if (!std::isnan(value)) rows_ += shortest(value);
  return *this;
}

CsvText& CsvText::cell(int value) {
  next();
  rows_ += std::to_string(value);
  return *this;
}

CsvText& CsvText::cell(std::string_view text) {
  next();
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    rows_ += text;
    return *this;
  }
  rows_ += '"';
  for (const char c : text) rows_.append(c == '"' ? 2 : 1, c);
  rows_ += '"';
  return *this;
}

CsvText& CsvText::end_row() {
  rows_ += '\n';
  first_ = true;
  return *this;
}

struct CsvFile::Part {
  OutputFile file;
};

CsvFile::CsvFile(std::filesystem::path path, const std::vector<std::string>& header)
    : path_(std::move(path)), part_(std::make_unique<Part>(Part{OutputFile(path_.string() + ".part")})) {
  for (const std::string& name : header) cell(name);
  end_row();
}

CsvFile::~CsvFile() {
  if (!part_) return;
  std::error_code ignored;  // nothing more can be done about a leftover
  std::filesystem::remove(part_->file.path(), ignored);
}

CsvFile& CsvFile::cell(double value) { return text_.cell(value), *this; }
CsvFile& CsvFile::cell(int value) { return text_.cell(value), *this; }
CsvFile& CsvFile::cell(std::string_view text) { return text_.cell(text), *this; }

void CsvFile::end_row() {
  constexpr std::size_t block = 1U << 16U;
  if (text_.end_row().rows().size() < block) return;
  part_->file.append(text_.rows());
  text_.clear();
}

void CsvFile::finish() {
  part_->file.append(text_.rows());
  text_.clear();
  part_->file.close();
  std::error_code failed;
  std::filesystem::rename(part_->file.path(), path_, failed);
  if (failed) throw std::runtime_error("writing " + path_.string() + ": " + failed.message());
  part_.reset();
}

}  // namespace perp
