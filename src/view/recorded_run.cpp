#include "perp/view/recorded_run.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

#include "core/index.hpp"
#include "io/run_recipe.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/csv_reader.hpp"

namespace perp {
namespace {

namespace fs = std::filesystem;

/// Where the numbers of one body stand in trajectory.csv.
struct BodyColumns {
  BodyMotion motion;
  int position = 0, orientation = -1, velocity = 0, turning = -1;
};

/// The part of a column's name after the last dot, and what stands before it.
std::pair<std::string, std::string> split(const std::string& column) {
  const std::size_t dot = column.rfind('.');
  return dot == std::string::npos ? std::pair(column, std::string())
                                  : std::pair(column.substr(0, dot), column.substr(dot + 1));
}

/// The bodies that the header names: by the parts that each has.
std::vector<BodyColumns> bodies_of(const CsvReader& file, const fs::path& path) {
  std::vector<BodyColumns> bodies;
  const std::vector<std::string>& header = file.header();
  for (std::size_t first = 1; first < header.size();) {
    const std::string name = split(header[first]).first;
    std::vector<std::string> parts;
    for (std::size_t i = first; i < header.size() && split(header[i]).first == name; ++i)
      parts.push_back(split(header[i]).second);
    const auto is = [&](std::initializer_list<const char*> wanted) {
      return std::equal(parts.begin(), parts.end(), wanted.begin(), wanted.end());
    };
    BodyColumns body;
    body.motion.name = name;
    body.position = static_cast<int>(first);
    if (is({"x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"})) {
      body.motion.kind = BodyMotion::Kind::Spatial;
      body.orientation = body.position + 3, body.velocity = body.position + 7;
      body.turning = body.position + 10;
    } else if (is({"x", "y", "angle", "vx", "vy", "omega"})) {
      body.motion.kind = BodyMotion::Kind::Planar;
      body.orientation = body.position + 2, body.velocity = body.position + 3;
      body.turning = body.position + 5;
    } else if (is({"x", "y", "z", "vx", "vy", "vz"})) {
      body.motion.kind = BodyMotion::Kind::Particle;
      body.velocity = body.position + 3;
    } else if (parts[0] == "q1" && parts.size() % 2 == 0) {
      body.motion.kind = BodyMotion::Kind::Generalized;
      body.motion.freedoms = static_cast<int>(parts.size() / 2);
      body.velocity = body.position + body.motion.freedoms;
    } else {
      throw std::invalid_argument(path.string() + ":1: the columns of '" + name +
                                  "' are not those of a body that perp run writes");
    }
    bodies.push_back(std::move(body));
    first += parts.size();
  }
  return bodies;
}

double finite(const CsvReader& file, int column) {
  const double value = file.number(column);
  if (!std::isfinite(value)) file.refuse_cell(column, "a finite number is needed");
  return value;
}

Vector3 finite_vector(const CsvReader& file, int column) {
  return {finite(file, column), finite(file, column + 1), finite(file, column + 2)};
}

void add_moment(const CsvReader& file, BodyColumns& body) {
  BodyMotion& motion = body.motion;
  if (motion.kind == BodyMotion::Kind::Generalized) {
    for (int i = 0; i < motion.freedoms; ++i) {
      motion.q.push_back(finite(file, body.position + i));
      motion.v.push_back(finite(file, body.velocity + i));
    }
    return;
  }
  Moment m;
  if (motion.kind == BodyMotion::Kind::Planar) {
    m.X.p = {finite(file, body.position), finite(file, body.position + 1), 0};
    m.X.q = rotation(Vector3(0, 0, finite(file, body.orientation)));
    m.V.v = {finite(file, body.velocity), finite(file, body.velocity + 1), 0};
    m.V.w = {0, 0, finite(file, body.turning)};
  } else {
    m.X.p = finite_vector(file, body.position);
    m.V.v = finite_vector(file, body.velocity);
  }
  if (motion.kind == BodyMotion::Kind::Spatial) {
    const Quaternion q(finite(file, body.orientation), finite(file, body.orientation + 1),
                       finite(file, body.orientation + 2), finite(file, body.orientation + 3));
    constexpr double allowed = 1e-6;  // files hold unit quaternions to rounding
    if (std::abs(q.norm() - 1) > allowed)
      file.refuse_cell(body.orientation, "the quaternion's length is not 1");
    m.X.q = q.normalized();
    m.V.w = finite_vector(file, body.turning);
  }
  motion.moments.push_back(m);
}

void read_trajectory(const fs::path& path, RecordedRun& run) {
  CsvReader file(path);
  if (file.header()[0] != "t")
    throw std::invalid_argument(path.string() + ":1: the first column is '" + file.header()[0] +
                                "', a trajectory's is 't'");
  std::vector<BodyColumns> bodies = bodies_of(file, path);
  while (file.next()) {
    const double t = finite(file, 0);
    if (!run.t.empty() && t < run.t.back()) file.refuse_cell(0, "time goes back");
    run.t.push_back(t);
    for (BodyColumns& body : bodies) add_moment(file, body);
  }
  if (run.t.empty()) throw std::invalid_argument(path.string() + ": there is no row below the header");
  for (BodyColumns& body : bodies) run.bodies.push_back(std::move(body.motion));
}

/// Every column of numbers of report.csv but t.
void read_report(const fs::path& path, RecordedRun& run) {
  CsvReader file(path);
  const int t = file.need("t");
  std::vector<int> columns;
  for (int i = 0; i < static_cast<int>(file.header().size()); ++i) {
    const std::string& column = file.header()[at(i)];
    if (i == t || column == "status" || column == "solver" || column == "advanced") continue;
    columns.push_back(i);
    run.series.push_back({.name = column, .t = {}, .y = {}});
  }
  const int status = file.need("status"), advanced = file.need("advanced");
  while (file.next()) {
    if (file.number(advanced) == 0) {
      run.status = "it stopped at t = " + std::string(file.text(t)) + " s: the step's status is " +
                   std::string(file.text(status));
      continue;
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      run.series[i].t.push_back(file.number(t));
      run.series[i].y.push_back(file.number(columns[i]));
    }
  }
}

/// Coordinates, rates and friction of joints, as JOINT.coordinate, ...
void read_joints(const fs::path& path, RecordedRun& run) {
  constexpr std::size_t most = 120;  // series that a list can still be picked from
  CsvReader file(path);
  const int t = file.need("t"), joint = file.need("joint");
  std::map<std::string, std::size_t, std::less<>> first;
  const std::vector<std::string> wanted{"coordinate", "rate", "friction"};
  std::vector<int> columns;
  for (const std::string& name : wanted) columns.push_back(file.need(name));
  while (file.next()) {
    auto found = first.find(file.text(joint));
    if (found == first.end()) {
      if (run.series.size() >= most) continue;
      found = first.emplace(file.text(joint), run.series.size()).first;
      for (const std::string& name : wanted)
        run.series.push_back({.name = found->first + "." + name, .t = {}, .y = {}});
    }
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      Series& series = run.series[found->second + i];
      series.t.push_back(file.number(t));
      series.y.push_back(file.number(columns[i]));
    }
  }
}

void read_events(const fs::path& path, RecordedRun& run) {
  CsvReader file(path);
  const int t = file.need("t"), kind = file.need("kind"), contact = file.need("contact"),
            before = file.need("before"), after = file.need("after");
  while (file.next())
    run.events.push_back({finite(file, t), std::string(file.text(kind)), std::string(file.text(contact)),
                          std::string(file.text(before)), std::string(file.text(after))});
}

/// Contact points over time, thinned while they are read: every second time goes as often as there are too many.
class ContactThinner {
 public:
  explicit ContactThinner(RecordedRun& run) : run_(run) {}

  /// Whether rows of time t are wanted; begins a moment where t is new.
  bool wants(double t) {
    if (!begun_ || t != last_) {
      begun_ = true;
      last_ = t;
      wanted_ = count_++ % stride_ == 0;
      if (wanted_) {
        if (rows_ > most_rows || run_.contact_t.size() > most_times) halve();
        run_.contact_t.push_back(t);
        run_.contacts.emplace_back();
      }
    }
    rows_ += wanted_ ? 1 : 0;
    return wanted_;
  }

 private:
  static constexpr std::size_t most_rows = 150000, most_times = 4000;

  void halve() {
    std::size_t kept = 0;
    rows_ = 0;
    for (std::size_t i = 0; i < run_.contact_t.size(); i += 2, ++kept) {
      run_.contact_t[kept] = run_.contact_t[i];
      if (kept != i) run_.contacts[kept] = std::move(run_.contacts[i]);
      rows_ += run_.contacts[kept].size();
    }
    run_.contact_t.resize(kept);
    run_.contacts.resize(kept);
    stride_ *= 2;
  }

  RecordedRun& run_;
  std::size_t count_ = 0, stride_ = 1, rows_ = 0;
  double last_ = 0;
  bool begun_ = false, wanted_ = false;
};

void read_contacts(const fs::path& path, RecordedRun& run) {
  CsvReader file(path);
  const int t = file.need("t"), contact = file.need("contact"), a = file.need("a"), b = file.need("b"),
            gap = file.need("gap"), n = file.need("nx"), pn = file.need("pn"), p = file.need("px"),
            f = file.need("fx"), mode = file.need("mode"), half = file.find("half");
  std::map<std::string, int, std::less<>> names;
  ContactThinner thinner(run);
  while (file.next()) {
    if (half >= 0 && file.text(half) != "0") continue;  // the halves of a step: their sum is there too
    if (!thinner.wants(finite(file, t))) continue;
    auto name = names.find(file.text(contact));
    if (name == names.end()) {
      name = names.emplace(file.text(contact), static_cast<int>(names.size())).first;
      run.contact_names.push_back(name->first);
      run.contact_bodies_a.emplace_back(file.text(a));
      run.contact_bodies_b.emplace_back(file.text(b));
    }
    ContactMoment m;
    m.name = name->second;
    m.gap = file.number(gap);
    for (int i = 0; i < 3; ++i) {
      m.normal[i] = file.number(n + i);
      const double force = file.number(f + i);
      m.force[i] = std::isfinite(force) ? force : 0;
    }
    m.normal_force = m.force.dot(m.normal);
    const std::string_view how = file.text(mode);
    m.mode = how == "stick" ? 'k' : how == "slip" ? 'p' : 'o';
    if (file.number(pn) == 0 && m.force.isZero(0) && file.number(p) == 0) m.mode = 'o';
    run.contacts.back().push_back(m);
  }
}

/// The scene, from what run.json keeps of it.
void read_run_record(const fs::path& path, RecordedRun& run) {
  if (!fs::exists(path)) {
    run.no_scene = "There is no run.json, so bodies are drawn as axes.";
    return;
  }
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const RunRecord record = read_record(text, path.string());
  run.method = record.recipe.method;
  if (run.status.empty() && record.exit_status != 0)
    run.status = record.ended.empty() ? "it is not complete" : record.ended;
  try {
    run.scene = make_scene(record.recipe);
    run.name = run.scene->name;
  } catch (const std::invalid_argument& error) {
    run.no_scene = "The scene of run.json can't be made again (" + std::string(error.what()) +
                   "), so bodies are drawn as axes.";
  }
}

}  // namespace

int RecordedRun::find_body(std::string_view body) const {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].name == body) return static_cast<int>(i);
  return -1;
}

RecordedRun read_recorded_run(const fs::path& folder) {
  const auto need = [&](const char* file) {
    if (!fs::exists(folder / file))
      refuse("perp view", folder.string(), std::string("without ") + file,
             "needs to be a folder that perp run wrote");
    return folder / file;
  };
  if (!fs::is_directory(folder))
    refuse("perp view", folder.string(), fs::exists(folder) ? "no folder" : "not there",
           "needs to be a folder that perp run wrote");
  RecordedRun run;
  run.name = fs::absolute(folder).lexically_normal().filename().string();
  if (run.name.empty()) run.name = fs::absolute(folder).lexically_normal().parent_path().filename().string();
  read_trajectory(need("trajectory.csv"), run);
  read_report(need("report.csv"), run);
  if (fs::exists(folder / "joints.csv")) read_joints(folder / "joints.csv", run);
  if (fs::exists(folder / "contacts.csv")) read_contacts(folder / "contacts.csv", run);
  if (fs::exists(folder / "events.csv")) read_events(folder / "events.csv", run);
  read_run_record(folder / "run.json", run);
  return run;
}

}  // namespace perp
