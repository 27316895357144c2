// Tosses of a cube as a camera would have measured them: true motions by `event`, then the faults of such data: a clock that runs slow,
// an edge that was measured too long, a table that is not at z = 0, noise. perp fit finds them again (doc/measured.md).
//   make_tosses [FOLDER [COUNT [SEED]]]
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <perp/perp.hpp>
#include <random>
#include <string>

namespace {

struct Truth {
  double mu = 0.18, e = 0.125, edge = 0.1023;  // edge [m]: 2.5 mm less than was written down
};

struct Faults {
  double rows_a_second = 149.5, said = 148;                // the clock: t in the file is k/said
  double table = -5e-4;                                    // height of the table in the file's frame [m]
  double noise_xy = 5e-5, noise_z = 2e-5, noise_q = 1e-4;  // standard deviations [m, m, -]
};

perp::Trajectory toss(const perp::Model& model, perp::BodyId cube, std::mt19937& random) {
  std::normal_distribution<double> normal;
  perp::State x = model.rest();
  const auto three = [&](double scale) {
    const double a = normal(random), b = normal(random), c = normal(random);
    return perp::Vector3(scale * a, scale * b, scale * c);
  };
  model.set_position(x, cube, {0.2, 0.2, 0.2});
  model.set_orientation(x, cube, perp::rotation(three(1)));
  model.set_velocity(x, cube, three(0.2) + perp::Vector3(-0.8, -0.6, 0), three(2));
  perp::EventDriven event({.rtol = 1e-8});
  return perp::simulate(model, event, x, {.t_end = 0.75});
}

void write(const std::filesystem::path& path, const perp::Model& model, perp::BodyId cube,
           const perp::Trajectory& run, const Faults& faults, std::mt19937& random) {
  std::normal_distribution<double> normal;
  perp::CsvFile csv(path, {"t", "cube.x", "cube.y", "cube.z", "cube.qw", "cube.qx", "cube.qy", "cube.qz"});
  const double last = run.t(run.size() - 1);
  for (int k = 0; k / faults.rows_a_second <= last; ++k) {
    const perp::Pose X = model.pose(run.at(k / faults.rows_a_second), cube);
    csv.cell(k / faults.said);
    csv.cell(X.p.x() + faults.noise_xy * normal(random)).cell(X.p.y() + faults.noise_xy * normal(random));
    csv.cell(X.p.z() + faults.table + faults.noise_z * normal(random));
    for (const double q : {X.q.w(), X.q.x(), X.q.y(), X.q.z()}) csv.cell(q + faults.noise_q * normal(random));
    csv.end_row();
  }
  csv.finish();
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder =
      argc > 1 ? std::filesystem::path(argv[1]) : std::filesystem::temp_directory_path() / "perp-tosses";
  const int count = argc > 2 ? std::stoi(argv[2]) : 2;
  std::mt19937 random(argc > 3 ? static_cast<unsigned>(std::stoul(argv[3])) : 1U);
  const Truth truth;
  const Faults faults;
  perp::Model model;
  const perp::BodyId cube =
      model.add_body(perp::Inertia::principal(0.37, perp::Vector3::Constant(8.1e-4)), {.name = "cube"});
  model.add_contact(perp::ground, cube, perp::box_on_plane(truth.edge * perp::Vector3::Ones()),
                    {.mu = truth.mu, .e = truth.e, .name = "table"});
  std::filesystem::create_directories(folder);
  int made = 0, refused = 0;
  while (made < count && refused < 10) {
    try {
      const perp::Trajectory run = toss(model, cube, random);
      char name[32];
      std::snprintf(name, sizeof name, "toss-%03d.csv", made);
      write(folder / name, model, cube, run, faults, random);
      ++made;
    } catch (const perp::StepFailure& failure) {  // said, and another one tossed
      std::fprintf(stderr, "a toss ended early: %s\n", failure.what());
      ++refused;
    }
  }
  std::printf("%d tosses in %s: mu %.3g, e %.3g, edge %.4g m, clock rate %.5g, table at %.2g m\n", made,
              folder.c_str(), truth.mu, truth.e, truth.edge, faults.said / faults.rows_a_second,
              faults.table);
  if (made < count) return 1;
  const perp::MeasuredMotion first = perp::read_measured(folder / "toss-000.csv");
  const double rest = first.values(first.values.rows() - 1, 2);
  std::printf("the first one ends %.2f mm above half the edge that was written down\n",
              1e3 * (rest - 0.0524));
  if (argc <= 1) std::filesystem::remove_all(folder);
  return std::isfinite(rest) ? 0 : 1;
}
