#include "io/run_table.hpp"

namespace perp {

CsvTable::CsvTable(const std::filesystem::path& path, const std::vector<RunColumn>& header,
                   std::uintmax_t position)
    : file_(path, position) {
  if (position > 0) return;
  for (const RunColumn& column : header) text_.cell(column.name);
  text_.end_row();
  flush();
}

void CsvTable::end_row() {
  constexpr std::size_t block = 1U << 16U;
  if (text_.end_row().rows().size() >= block) flush();
}

void CsvTable::flush() {
  file_.append(text_.rows());
  text_.clear();
  file_.need_there();
}

void CsvTable::close() {
  flush();
  file_.close();
}

}  // namespace perp
