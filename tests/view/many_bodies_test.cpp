// A thousand spheres: how large their page is, and what a frame of it costs.
#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "perp/core/types.hpp"

#include "perp/study/scene.hpp"
#include "tests/view/in_browser.hpp"

namespace perp {
namespace {

/// Spheres that bounce on the floor of the pile's box, each by itself, for `length` seconds in rows of 1/60 s: what a page has to hold of
/// a motion that never calms down. The motion between two impacts is a parabola, turning at a constant rate.
RecordedRun bouncing(int count, double length) {
  RecordedRun run;
  run.scene = scene("pile", {{"count", count}});
  run.name = "bouncing";
  run.method = "closed form";
  const int rows = static_cast<int>(60 * length);
  for (int i = 0; i <= rows; ++i) run.t.push_back(i / 60.0);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto& bodies = run.scene->model.bodies();
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    BodyMotion& body = run.bodies.emplace_back();
    body.name = bodies[b].name;
    const Vector3 start = run.scene->model.pose(run.scene->start, {static_cast<int>(b)}).p;
    const double half = 0.3 + 0.5 * unit(random), phase = unit(random), g = 9.81;  // half a flight [s]
    Vector3 w(6 * unit(random) - 3, 6 * unit(random) - 3, 6 * unit(random) - 3);
    for (const double t : run.t) {
      const double flight = std::floor(t / (2 * half) + phase), s = t + 2 * half * (phase - flight) - half;
      Moment m;
      m.X.p = {start.x(), start.y(), start.z() + 0.5 * g * (half * half - s * s)};
      m.X.q = rotation(w * t);
      m.V = {{0, 0, -g * s}, w};
      body.moments.push_back(m);
    }
  }
  return run;
}

/// Processor time of all processes that were started and have ended [s].
double spent_by_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

TEST_CASE("the page of 60 s of a thousand spheres is below 60 MB, and its error is that of a pixel",
          "[view][slow]") {
  const RecordedRun run = bouncing(1000, 60);
  PageFacts facts;
  const std::string page = page_of({run}, facts);
  WARN("page: " << 1e-6 * static_cast<double>(page.size()) << " MB, " << facts.keys
                << " keys, positions within " << facts.position_error << " m, orientations within "
                << facts.turning_error << " rad");
  CHECK(page.size() < 60'000'000);
  CHECK(facts.rows == 3601);
  CHECK(facts.position_error < 0.1);  // of a scene of 30 m across
  CHECK(facts.turning_error < 0.02);
}

TEST_CASE("a frame of a thousand spheres takes 50 ms of a processor at most, drawn without a GPU",
          "[view][browser][slow]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-frames");
  PageFacts facts;
  std::ofstream(scratch / "page.html", std::ios::binary) << page_of({bouncing(1000, 2)}, facts);
  // what more frames cost, by the processor time of the browser's processes: on a busy machine the wall clock would tell of others
  const auto cost = [&](int frames) {
    const double before = spent_by_children();
    const nlohmann::json out = asked(scratch, browser,
                                     R"js(
      const canvas = document.getElementById('scene'), gl = canvas.getContext('webgl') || canvas.getContext('webgl2'), pixel = new Uint8Array(4);
      document.body.style.height = '600px';
      window.dispatchEvent(new Event('resize'));
      out.lit = 0;
      for (let i = 0; i < )js" + std::to_string(frames) +
                                         R"js(; ++i) {
        perp.seek(2 * (i + .5) / )js" + std::to_string(frames) +
                                         R"js();
        gl.readPixels(gl.drawingBufferWidth / 2, gl.drawingBufferHeight / 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);  // waits for the frame
        out.lit += pixel[3] > 0 ? 1 : 0;
      }
      out.size = [gl.drawingBufferWidth, gl.drawingBufferHeight];)js");
    CHECK(out["lit"] == frames);
    CHECK(out["size"] == nlohmann::json({800, 600}));
    return spent_by_children() - before;
  };
  double few = infinity, many = infinity;  // the least of three: starting a browser costs now more, now less
  for (int i = 0; i < 3; ++i) few = std::min(few, cost(10)), many = std::min(many, cost(90));
  const double frame = (many - few) / 80;
  WARN("a frame: " << 1000 * frame << " ms of processor time");
  CHECK(frame > 0.001);  // it was drawn
  CHECK(frame < 0.05);
}

}  // namespace
}  // namespace perp
