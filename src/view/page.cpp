#include "perp/view/page.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "perp/version.hpp"
#include "view/drawing.hpp"
#include "view/encode.hpp"
#include "view/keyframes.hpp"
#include "view/page_text.hpp"

namespace perp {
namespace {

using nlohmann::json;

json listed(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
json listed(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// How finely motions are kept: the finest whose keys fit into the page's share for them.
struct Fineness {
  double tolerance = 1e-6;  ///< of the scene's radius, and in rad
  Precision precision = Precision::Double;
};

struct ThinnedBody {
  const DrawnBody* body;
  Keyframes keys;
};

std::vector<ThinnedBody> thin(const std::vector<Drawing>& drawings, double radius, double tolerance) {
  std::vector<ThinnedBody> all;
  for (const Drawing& drawing : drawings)
    for (const DrawnBody& body : drawing.bodies)
      all.push_back({&body, thinned(body.t, body.moments, tolerance * radius, tolerance)});
  return all;
}

/// Thins until the keys fit: in doubles to a millionth of the scene where they do, coarser where they do not.
std::vector<ThinnedBody> fitting(const std::vector<Drawing>& drawings, double radius, Fineness& fineness) {
  std::size_t bodies = 0;
  for (const Drawing& d : drawings) bodies += d.bodies.size();
  const std::size_t most_bytes = std::max<std::size_t>(4000000, 32000 * bodies);
  constexpr double coarsest = 3e-3;  // a picture of 800 pixels shows two of them
  std::vector<ThinnedBody> all;
  for (const Precision precision : {Precision::Double, Precision::Single, Precision::Whole}) {
    const std::size_t bytes_a_key = precision == Precision::Double   ? 112
                                    : precision == Precision::Single ? 60
                                                                     : 34;
    for (double tolerance = precision == Precision::Double ? 1e-6 : 1e-5;
         tolerance <= (precision == Precision::Whole ? coarsest : 1e-5); tolerance *= 4) {
      all = thin(drawings, radius, tolerance);
      fineness = {tolerance, precision};
      std::size_t keys = 0;
      for (const ThinnedBody& b : all) keys += b.keys.rows.size();
      if (keys * bytes_a_key <= most_bytes) return all;
    }
  }
  return all;
}

/// Columns t, p, q, v, w of the keys; the facts' errors grow to those of the stored numbers.
json encoded_keys(const ThinnedBody& thinned, Precision precision, PageFacts& facts) {
  const DrawnBody& body = *thinned.body;
  std::vector<double> t, p, q, v, w;
  for (const int row : thinned.keys.rows) {
    const Moment& m = body.moments[at(row)];
    t.push_back(body.t[at(row)]);
    p.insert(p.end(), m.X.p.begin(), m.X.p.end());
    for (const double x : {m.X.q.w(), m.X.q.x(), m.X.q.y(), m.X.q.z()}) q.push_back(x);
    v.insert(v.end(), m.V.v.begin(), m.V.v.end());
    w.insert(w.end(), m.V.w.begin(), m.V.w.end());
  }
  facts.keys += t.size();
  double none = 0, position = 0, turning = 0, speed = 0, rate = 0, longest = 0;
  for (std::size_t i = 1; i < t.size(); ++i) longest = std::max(longest, t[i] - t[i - 1]);
  json keys{{"t", encoded(t, 1, Precision::Double, none)},
            {"p", encoded(p, 3, precision, position)},
            {"q", encoded(q, 4, precision, turning)},
            {"v", encoded(v, 3, precision, speed)},
            {"w", encoded(w, 3, precision, rate)}};
  // an error of a slope enters the cubic by at most 8/27 of it over the interval, from both ends
  constexpr double of_slopes = 8.0 / 27;
  facts.position_error =
      std::max(facts.position_error,
               thinned.keys.position_error + std::sqrt(3.0) * (position + of_slopes * longest * speed));
  facts.turning_error = std::max(facts.turning_error, thinned.keys.turning_error + 4 * turning +
                                                          std::sqrt(3.0) * of_slopes * longest * rate);
  return keys;
}

json encoded_solid(const Solid& solid) {
  json out{{"kind", name_of(solid.kind)},
           {"size", listed(solid.size)},
           {"place", {listed(solid.place.p), listed(solid.place.q)}}};
  if (solid.inferred) out["inferred"] = true;
  for (const Vector3& v : solid.vertices) out["vertices"].push_back(listed(v));
  for (const std::vector<int>& face : solid.faces) out["faces"].push_back(face);
  return out;
}

/// All rows, or where they are many the smallest and largest of every few: what a plot shows.
json encoded_series(const Series& series) {
  constexpr std::size_t most = 2000;
  std::vector<double> t, y;
  const std::size_t n = series.t.size(), stride = n / most + 1;
  const auto keep = [&](std::size_t i) { t.push_back(series.t[i]), y.push_back(series.y[i]); };
  for (std::size_t first = 0; first < n; first += stride) {
    std::size_t low = first, high = first;
    for (std::size_t i = first; i < std::min(n, first + stride); ++i) {
      if (!(series.y[i] >= series.y[low])) low = i;
      if (!(series.y[i] <= series.y[high])) high = i;
    }
    keep(std::min(low, high));
    if (low != high) keep(std::max(low, high));
  }
  double none = 0;
  return {{"name", series.name},
          {"t", encoded(t, 1, Precision::Double, none)},
          {"y", encoded(y, 1, Precision::Double, none)}};
}

/// Coordinates and velocities of generalized bodies as series.
std::vector<Series> generalized_series(const RecordedRun& run) {
  std::vector<Series> all;
  for (const BodyMotion& body : run.bodies) {
    const auto n = static_cast<std::size_t>(body.freedoms);
    for (std::size_t k = 0; k < 2 * n; ++k) {
      Series s{.name = body.name + (k < n ? ".q" : ".v") + std::to_string(k % n + 1), .t = run.t, .y = {}};
      for (std::size_t i = 0; i < run.t.size(); ++i) s.y.push_back((k < n ? body.q : body.v)[i * n + k % n]);
      all.push_back(std::move(s));
    }
  }
  return all;
}

/// Of contact points that press: where, which normal force and friction, relative to the largest of their time.
json encoded_contacts(const RecordedRun& run, const Drawing& drawing) {
  std::vector<double> t, first{0}, position, normal, friction, scale;
  std::vector<unsigned char> mode;
  std::vector<double> name;
  for (std::size_t k = 0; k < drawing.contact_points.size(); ++k) {
    double largest = 0;
    for (const ContactMoment& m : run.contacts[k]) largest = std::max(largest, m.force.norm());
    for (std::size_t i = 0; i < run.contacts[k].size(); ++i) {
      const ContactMoment& m = run.contacts[k][i];
      const Vector3& p = drawing.contact_points[k][i];
      if (m.mode == 'o' || !p.allFinite()) continue;
      const double unit = largest > 0 ? largest : 1;
      const Vector3 n = m.normal_force / unit * m.normal, f = m.force / unit - n;
      position.insert(position.end(), p.begin(), p.end());
      normal.insert(normal.end(), n.begin(), n.end());
      friction.insert(friction.end(), f.begin(), f.end());
      mode.push_back(m.mode == 'k' ? 1 : 2);
      name.push_back(m.name);
    }
    t.push_back(run.contact_t[k]);
    scale.push_back(largest);
    first.push_back(static_cast<double>(mode.size()));
  }
  double reach = 0;  // a row speaks for the times up to the next
  for (std::size_t k = 1; k < t.size(); ++k) reach = std::max(reach, t[k] - t[k - 1]);
  double none = 0;
  return {{"t", encoded(t, 1, Precision::Double, none)},
          {"first", encoded(first, 1, Precision::Double, none)},
          {"position", encoded(position, 3, Precision::Whole, none)},
          {"normal", encoded(normal, 3, Precision::Whole, none)},
          {"friction", encoded(friction, 3, Precision::Whole, none)},
          {"scale", encoded(scale, 1, Precision::Double, none)},
          {"mode", encoded_bytes(mode)},
          {"name", encoded(name, 1, Precision::Single, none)},
          {"names", run.contact_names},
          {"reach", std::max(reach, 1e-9)}};
}

/// Such that of all forces nine in ten are drawn shorter than a third of the scene.
double metres_per_newton(const RecordedRun& run, double radius) {
  std::vector<double> forces;
  for (const auto& moment : run.contacts)
    for (const ContactMoment& m : moment)
      if (m.force.norm() > 0) forces.push_back(m.force.norm());
  if (forces.empty()) return 0;
  const auto ninth = forces.begin() + static_cast<std::ptrdiff_t>(9 * (forces.size() - 1) / 10);
  std::nth_element(forces.begin(), ninth, forces.end());
  return 0.33 * radius / *ninth;
}

json encoded_run(const RecordedRun& run, const Drawing& drawing, const ThinnedBody*& thinned,
                 const Fineness& fineness, PageFacts& facts) {
  json out{{"name", run.name},
           {"bodies", json::array()},
           {"joints", json::array()},
           {"series", json::array()},
           {"events", json::array()}};
  for (const DrawnBody& body : drawing.bodies) {
    json solids = json::array();
    double extent = 0;
    for (const Solid& s : body.solids) {
      solids.push_back(encoded_solid(s));
      extent = std::max(extent, extent_of(s));
    }
    out["bodies"].push_back({{"name", body.name},
                             {"kind", body.kind},
                             {"colour", body.colour},
                             {"extent", extent},
                             {"solids", std::move(solids)},
                             {"keys", encoded_keys(*thinned++, fineness.precision, facts)}});
  }
  for (const DrawnJoint& joint : drawing.joints) {
    json j{{"name", joint.name}, {"a", joint.body}, {"anchor", listed(joint.anchor)}};
    if (!joint.axis.isZero(0)) j["axis"] = listed(joint.axis);
    out["joints"].push_back(std::move(j));
  }
  for (const Series& series : run.series) out["series"].push_back(encoded_series(series));
  for (const Series& series : generalized_series(run)) out["series"].push_back(encoded_series(series));
  for (const RunEvent& e : run.events)
    out["events"].push_back(
        {{"t", e.t}, {"kind", e.kind}, {"contact", e.contact}, {"before", e.before}, {"after", e.after}});
  if (!drawing.contact_points.empty()) out["contacts"] = encoded_contacts(run, drawing);
  return out;
}

/// A speed at which the run takes half a minute at most and four seconds at least, of those that the page offers.
double speed_of(double length) {
  double speed = 1;
  for (const double s : {10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001}) {
    speed = s;
    if (length / s >= 4) break;
  }
  return speed;
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

/// What stands below the title: what is not drawn, and why.
std::string said(const std::vector<RecordedRun>& runs, const Drawing& drawing) {
  std::string text;
  const auto add = [&](const std::string& sentence) { text += (text.empty() ? "" : " ") + sentence; };
  for (const RecordedRun& run : runs) {
    if (!run.status.empty())
      add((runs.size() > 1 ? run.name + ": " : "") + "This run did not reach its end: " + run.status +
          (run.status.ends_with('.') ? "" : "."));
    if (!run.no_scene.empty()) add(run.no_scene);
  }
  if (runs[0].contact_names.empty() && runs[0].contact_t.empty()) add("No contact is recorded.");
  for (const std::string& name : drawing.unseen)
    add("'" + name + "' has coordinates of its own and no pose: see its plots.");
  return text;
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Text inside a script element: nothing that could end it.
std::string in_script(std::string text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text)
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  return out;
}

std::string in_html(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

/// `text` with @NAME@ replaced.
void put(std::string& text, const std::string& name, const std::string& by) {
  const std::string mark = "@" + name + "@";
  const std::size_t place = text.find(mark);
  text.replace(place, mark.size(), by);
}

}  // namespace

std::string page_of(const std::vector<RecordedRun>& runs, PageFacts& facts, const PageOptions& options) {
  if (runs.empty() || runs.size() > 2)
    refuse("page_of", "number of runs", static_cast<double>(runs.size()), "needs to be 1 or 2");
  facts = {};
  std::vector<Drawing> drawings;
  for (const RecordedRun& run : runs) {
    drawings.push_back(drawing_of(run));
    facts.rows += run.t.size();
  }
  const Drawing& first = drawings[0];
  Fineness fineness;
  const std::vector<ThinnedBody> thinned = fitting(drawings, first.radius, fineness);
  json data{{"title", runs[0].name + (runs[0].method.empty() ? "" : " by " + runs[0].method) +
                          (runs.size() > 1
                               ? ", over it " + runs[1].name +
                                     (runs[1].method.empty() ? "" : " by " + runs[1].method) + " as a ghost"
                               : "")},
            {"said", said(runs, first)},
            {"stopped", !runs[0].status.empty()},
            {"time", {runs[0].t.front(), std::max(runs[0].t.back(), runs.back().t.back())}},
            {"flat", first.flat},
            {"up", listed(first.up)},
            {"centre", listed(first.centre)},
            {"radius", first.radius},
            {"box", {listed(first.low), listed(first.high)}},
            {"metres_per_newton", metres_per_newton(runs[0], first.radius)},
            {"runs", json::array()}};
  data["speed"] = speed_of(runs[0].t.back() - runs[0].t.front());
  const ThinnedBody* next = thinned.data();
  for (std::size_t i = 0; i < runs.size(); ++i)
    data["runs"].push_back(encoded_run(runs[i], drawings[i], next, fineness, facts));
  data["data_said"] = std::to_string(facts.rows) + " rows, of which " + std::to_string(facts.keys) +
                      " keys over all bodies are kept, with cubics between them: positions within " +
                      number(facts.position_error) + " m and orientations within " +
                      number(facts.turning_error) + " rad of the rows.";

  std::string libraries;
  facts.has_three = std::filesystem::is_regular_file(options.three);
  if (facts.has_three) {
    std::string three = read_text(options.three);
    for (std::size_t i = 0; (i = three.find("</script", i)) != std::string::npos;)
      three.replace(i, 2, "<\\/");
    libraries = "<script>\n" + three + "\n</script>";
  }
  std::string page(page_html);
  put(page, "VERSION", std::string(version));
  put(page, "TITLE", in_html(data["title"].get<std::string>()));
  put(page, "CSS", std::string(page_css));
  put(page, "JS", std::string(page_js));
  put(page, "LIBRARIES", libraries);
  put(page, "DATA", in_script(data.dump(-1, ' ', false, json::error_handler_t::replace)));
  facts.bytes = page.size();
  return page;
}

}  // namespace perp
