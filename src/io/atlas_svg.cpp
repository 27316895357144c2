// Maps as pictures: cells told apart by signs, and by colours that the colour-blind tell apart too.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>

#include "core/files.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/atlas.hpp"
#include "perp/io/csv_file.hpp"

namespace perp {
namespace {

constexpr double side = 440, left = 84, top = 58, between = 210;

/// How a kind of cell looks: its colour and the strokes of its sign in a square of side 1.
struct Look {
  std::string_view name;
  const char* fill;
  const char* sign;  // a path in [0, 1]^2
};

constexpr Look verdicts[] = {{"right", "#eaf3fa", ""},
                             {"off", "#E69F00", "M.5 .25 A.25 .25 0 1 1 .499 .25"},
                             {"said-so", "#56B4E9", "M.15 .5 L.85 .5"},
                             {"silent", "#D55E00", "M.15 .15 L.85 .85 M.85 .15 L.15 .85"}};
constexpr Look outcomes[] = {{"unknown", "#ffffff", "M.35 .65 L.65 .35"},
                             {"sticks", "#cfd8dc", ""},
                             {"slides", "#009E73", "M.15 .5 L.85 .5 M.6 .3 L.85 .5 L.6 .7"},
                             {"jumps", "#CC79A7", "M.5 .85 L.5 .15 M.3 .4 L.5 .15 L.7 .4"},
                             {"bounded", "#eaf3fa", "M.5 .35 A.15 .15 0 1 1 .499 .35"},
                             {"grows", "#D55E00", "M.15 .15 L.85 .85 M.85 .15 L.15 .85"}};

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text)
    result += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return result;
}

std::string in_short(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

class Panel {
 public:
  Panel(const AtlasRequest& request, double x, std::ostringstream& out) : r_(request), x_(x), out_(out) {
    w_ = side / r_.a.count, h_ = side / r_.b.count;
  }

  void cell(int i, int j, const Look& look) {
    const double x = x_ + i * w_, y = top + side - (j + 1) * h_;
    out_ << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << w_ << "\" height=\"" << h_ << "\" fill=\""
         << look.fill << "\" stroke=\"#fff\" stroke-width=\".5\"/>";
    sign(x, y, std::min(w_, h_), w_, h_, look);
    seen_.insert(look.name);
  }

  template <std::size_t N>
  void frame(const char* title, const Look (&looks)[N]) {
    text(x_, top - 14, title, "start", 16);
    for (const int k : {0, 1, 2}) {
      const double share = k / 2.0;
      const auto value = [&](const AtlasAxis& axis) {
        return in_short(axis.geometric() ? axis.low * std::pow(axis.high / axis.low, share)
                                         : axis.low + share * (axis.high - axis.low));
      };
      text(x_ + share * side, top + side + 20, value(r_.a), k == 0 ? "start" : k == 1 ? "middle" : "end", 13);
      text(x_ - 8, top + side - share * (side - 10), value(r_.b), "end", 13);
    }
    text(x_ + side / 2, top + side + 42, r_.a.name, "middle", 15);
    text(x_ - 8, top - 14, r_.b.name, "end", 15);
    double y = top + 10;
    for (const Look& look : looks) {
      if (seen_.count(look.name) == 0) continue;
      out_ << "<rect x=\"" << x_ + side + 14 << "\" y=\"" << y - 12 << "\" width=\"16\" height=\"16\" fill=\""
           << look.fill << "\" stroke=\"#999\" stroke-width=\".7\"/>";
      sign(x_ + side + 14, y - 12, 16, 16, 16, look);
      text(x_ + side + 38, y + 1, look.name, "start", 14);
      y += 25;
    }
  }

  void text(double x, double y, std::string_view words, const char* anchor, int size) {
    out_ << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\" font-size=\"" << size
         << "\" fill=\"#222\">" << escaped(words) << "</text>\n";
  }

 private:
  void sign(double x, double y, double size, double w, double h, const Look& look) {
    if (look.sign[0] == '\0') return;
    out_ << "<path transform=\"translate(" << x + (w - size) / 2 << " " << y + (h - size) / 2 << ") scale("
         << size << ")\" d=\"" << look.sign << "\" fill=\"none\" stroke=\"#222\" stroke-width=\".09\"/>\n";
  }

  const AtlasRequest& r_;
  double x_, w_ = 0, h_ = 0;
  std::ostringstream& out_;
  std::set<std::string_view> seen_;
};

std::string picture(const AtlasRequest& request, const std::string& method,
                    const std::vector<AtlasCell>& cells) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  const double width = left + 2 * side + between + 130, height = top + side + 62;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << " " << height
      << "\" font-family=\"Helvetica, Arial, sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
         "fill=\"#fff\"/>\n";
  Panel first(request, left, out), second(request, left + side + between, out);
  first.text(left, 22, request.scene + ", " + method, "start", 18);
  std::size_t k = 0;
  for (const AtlasCell& cell : cells) {
    if (cell.method != method) continue;
    const int i = static_cast<int>(k) % request.a.count, j = static_cast<int>(k) / request.a.count;
    first.cell(i, j, verdicts[static_cast<std::size_t>(cell.verdict)]);
    second.cell(i, j, outcomes[static_cast<std::size_t>(cell.outcome)]);
    ++k;
  }
  first.frame("", verdicts);
  second.frame("outcome", outcomes);
  out << "</svg>\n";
  return out.str();
}

}  // namespace

void write_atlas(const AtlasRequest& request, const std::vector<AtlasCell>& cells,
                 const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  CsvFile csv(folder / "map.csv",
              {"method", request.a.name, request.b.name, "verdict", "outcome", "error", "reason"});
  for (const AtlasCell& cell : cells) {
    csv.cell(cell.method).cell(cell.a).cell(cell.b).cell(name_of(cell.verdict)).cell(name_of(cell.outcome));
    csv.cell(cell.error).cell(cell.reason).end_row();
  }
  csv.finish();
  for (const std::string& method : request.methods)
    replace_file(folder / (method + "-map.svg"), picture(request, method, cells));
}

}  // namespace perp
