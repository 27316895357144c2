// The page in a real browser: what it shows is what the files say.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/core/types.hpp"
#include "tests/view/in_browser.hpp"

namespace perp {
namespace {

using nlohmann::json;

TEST_CASE("in the browser poses, values and events are those of the files", "[view][browser]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-browser");
  REQUIRE(
      run_perp(scratch, "run double-pendulum --method event --tolerance 1e-8 --until 1 --step 0.25 --out " +
                            (scratch / "o"))
          .status == 0);
  REQUIRE(run_perp(scratch, "view " + (scratch / "o") + " --html " + (scratch / "page.html")).status == 0);
  auto rows = columns(scratch / "o/trajectory.csv");
  const std::size_t n = rows["t"].size();
  std::string script = "out.poses = [];";
  const std::size_t picked[] = {0, n / 2, n - 1};
  for (const std::size_t i : picked)
    script += "perp.seek(" + rows["t"][i] + "); out.poses.push([perp.time, perp.pose('upper')]);";
  const json out =
      asked(scratch, browser, script + "out.network = performance.getEntriesByType('resource').length;");
  CHECK(out["network"] == 0);
  for (std::size_t k = 0; k < 3; ++k) {
    const json& pose = out["poses"][k][1];
    const auto value = [&](const char* column) {
      return std::stod(rows[std::string("upper.") + column][picked[k]]);
    };
    CHECK(out["poses"][k][0].get<double>() == std::stod(rows["t"][picked[k]]));
    CHECK(pose["position"][0].get<double>() == Approx(value("x")).margin(3e-6));
    const bool flat = rows.count("upper.angle") > 0;
    CHECK(pose["position"][flat ? 1 : 2].get<double>() == Approx(value(flat ? "y" : "z")).margin(3e-6));
    REQUIRE(flat);
    const double w = std::cos(value("angle") / 2), z = std::sin(value("angle") / 2);
    CHECK(std::abs(pose["orientation"][0].get<double>() * w + pose["orientation"][3].get<double>() * z) ==
          Approx(1).margin(1e-11));
  }
}

TEST_CASE("a ball is drawn where a pinhole camera sees it, within three pixels", "[view][browser]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-pixels");
  REQUIRE(run_perp(scratch, "run seed-sphere --method ncp2 --step 0.01 --until 0.6 --out " + (scratch / "o"))
              .status == 0);
  REQUIRE(run_perp(scratch, "view " + (scratch / "o") + " --html " + (scratch / "page.html")).status == 0);
  auto rows = columns(scratch / "o/trajectory.csv");
  const json out = asked(scratch, browser, R"js(
    for (const what of ['contacts', 'forces', 'labels']) perp.show(what, false);
    const canvas = document.getElementById('scene'), copy = document.createElement('canvas');
    out.seen = [];
    for (const [eye, target] of [[[0.4, -14, 5], [0, 0, 0]], [[9, -9, 9], [1, 0, 1]]]) for (const t of [0, 0.3, 0.6]) {
      perp.look(eye, target);
      perp.seek(t);
      copy.width = canvas.width; copy.height = canvas.height;
      const g = copy.getContext('2d');
      g.drawImage(canvas, 0, 0);
      const d = g.getImageData(0, 0, copy.width, copy.height).data;
      let n = 0, x = 0, y = 0;
      for (let i = 0; i < d.length; i += 4) if (d[i + 2] > d[i] + 50) { ++n; x += i / 4 % copy.width; y += Math.floor(i / 4 / copy.width); }
      out.seen.push({ n, x: (x / n + .5) * perp.camera().width / copy.width, y: (y / n + .5) * perp.camera().height / copy.height, t, camera: perp.camera() });
    })js");
  REQUIRE(out["seen"].size() == 6);
  for (const json& seen : out["seen"]) {
    const auto vector = [&](const char* key) {
      return Vector3(seen["camera"][key][0], seen["camera"][key][1], seen["camera"][key][2]);
    };
    const Vector3 eye = vector("position"), forth = (vector("target") - eye).normalized();
    const Vector3 right = forth.cross(vector("up")).normalized(), up = right.cross(forth);
    const auto row = static_cast<std::size_t>(std::lround(seen["t"].get<double>() / 0.01));
    const Vector3 ball(std::stod(rows["ball.x"][row]), std::stod(rows["ball.y"][row]),
                       std::stod(rows["ball.z"][row]));
    const double width = seen["camera"]["width"], height = seen["camera"]["height"],
                 fov = seen["camera"]["fov"];
    const double focal = 0.5 * height / std::tan(fov * M_PI / 360), depth = (ball - eye).dot(forth);
    CHECK(seen["n"].get<double>() > 400);
    CHECK(seen["x"].get<double>() == Approx(0.5 * width + focal * (ball - eye).dot(right) / depth).margin(3));
    CHECK(seen["y"].get<double>() == Approx(0.5 * height - focal * (ball - eye).dot(up) / depth).margin(3));
  }
}

TEST_CASE("the page plays, jumps to events, obeys the keyboard, and stands without WebGL",
          "[view][browser]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-plays");
  REQUIRE(run_perp(scratch,
                   "run bouncing-ball --method event --tolerance 1e-8 --until 1 --out " + (scratch / "o"))
              .status == 0);
  REQUIRE(run_perp(scratch, "view " + (scratch / "o") + " --html " + (scratch / "page.html")).status == 0);
  auto events = columns(scratch / "o/events.csv");
  REQUIRE(!events["t"].empty());
  const std::string script = R"js(
    const key = k => window.dispatchEvent(new KeyboardEvent('keydown', { key: k }));
    perp.seek(0); key('n'); out.after_n = perp.time; key('End'); out.after_end = perp.time; key('Home'); out.after_home = perp.time;
    document.querySelector('#events button').click(); out.clicked = perp.time;
    key(' '); out.playing = perp.playing; key(' '); out.paused = perp.playing;
    out.events = perp.events.length; out.notice = document.getElementById('no-scene').textContent;
    const plot = document.getElementById('plot'), box = plot.getBoundingClientRect();
    plot.dispatchEvent(new MouseEvent('click', { clientX: box.left + box.width / 2, clientY: box.top + 20 })); out.plot = perp.time;)js";
  for (const char* fragment : {"", "nowebgl"}) {
    const json out = asked(scratch, browser, script, fragment);
    INFO(out.dump());
    CHECK(out["after_n"].get<double>() == Approx(std::stod(events["t"][0])).margin(1e-12));
    CHECK(out["clicked"].get<double>() == Approx(std::stod(events["t"][0])).margin(1e-12));
    CHECK(out["after_end"] == 1);
    CHECK(out["after_home"] == 0);
    CHECK(out["playing"] == true);
    CHECK(out["paused"] == false);
    CHECK(out["events"] == events["t"].size());
    CHECK(out["plot"].get<double>() == Approx(0.5).margin(0.01));
    CHECK((out["notice"].get<std::string>().find("WebGL is switched off") != std::string::npos) ==
          (std::string(fragment) == "nowebgl"));
  }
}

TEST_CASE("a browser that gives no WebGL shows plots, values and events, and says so", "[view][browser]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-refused-webgl");
  REQUIRE(
      run_perp(scratch, "run bouncing-ball --method event --tolerance 1e-8 --until 1 --view --quiet --out " +
                            (scratch / "o"))
          .status == 0);
  std::filesystem::copy(scratch / "o/view.html", scratch / "page.html");
  std::string page = contents(scratch / "page.html");
  page.insert(
      page.find("<head>") + 6,
      "<script>HTMLCanvasElement.prototype.getContext = (get => function (kind, ...more) {"
      "return kind.startsWith('w') || kind.startsWith('exp') ? null : get.call(this, kind, ...more); })"
      "(HTMLCanvasElement.prototype.getContext);</script>");
  std::ofstream(scratch / "page.html", std::ios::binary) << page;
  const json out = asked(scratch, browser, R"js(
    perp.seek(0.5); out.t = document.getElementById('clock').textContent; out.buttons = document.querySelectorAll('#events button').length;
    out.notice = document.getElementById('no-scene').textContent; out.values = document.querySelectorAll('#values tr').length;)js",
                         "");
  CHECK(out["notice"].get<std::string>().find("This browser gives no WebGL") != std::string::npos);
  CHECK(out["t"] == "t = 0.500 s");
  CHECK(out["buttons"].get<int>() > 0);
  CHECK(out["values"].get<int>() > 4);
}

TEST_CASE("a page written without three.js says so and keeps plots and values", "[view][browser]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-without-three");
  REQUIRE(run_perp(scratch, "run seed-sphere --method lcp --step 0.1 --out " + (scratch / "o")).status == 0);
  PageFacts facts;
  std::ofstream(scratch / "page.html", std::ios::binary)
      << page_of({read_recorded_run(scratch.path / "o")}, facts, {.three = scratch.path / "none.js"});
  const json out = asked(scratch, browser, R"js(
    perp.seek(0.3); out.x = perp.pose('ball').position[0]; out.energy = perp.value('energy');
    out.notice = document.getElementById('no-scene').textContent;)js",
                         "");
  auto rows = columns(scratch / "o/trajectory.csv");
  CHECK(out["x"].get<double>() == Approx(std::stod(rows["ball.x"][3])).margin(1e-6));
  CHECK(out["energy"].get<double>() > 0);
  CHECK(out["notice"].get<std::string>().find(
            "This page was written without three.js (Debian: libjs-three)") != std::string::npos);
}

TEST_CASE("names with markup, quotes and letters of any script are shown as they are", "[view][browser]") {
  const std::string browser = need_browser();
  if (browser.empty()) return;
  const Scratch scratch("view-names");
  RecordedRun run;
  run.name = "</script><script>throw 1</script> \"it's\" & 滑る";
  run.t = {0, 1};
  const std::string names[] = {"</script><b>", "\"quoted\" 'both' \\", "мяч-球-é", "<!--"};
  for (const std::string& name : names) {
    BodyMotion& body = run.bodies.emplace_back();
    body.name = name;
    const double x = static_cast<double>(run.bodies.size());
    body.moments = {{{{x, 0, 0}, Quaternion::Identity()}, {}},
                    {{{x, 0, 1}, Quaternion::Identity()}, {{0, 0, 1}, Vector3::Zero()}}};
  }
  run.series = {{.name = "</td>&amp;", .t = {0, 1}, .y = {1, 2}}};
  run.events = {{0.5, "touch", "<img src=x onerror=throw>", "", "\"stick\""}};
  PageFacts facts;
  std::ofstream(scratch / "page.html", std::ios::binary) << page_of({run}, facts);
  const json out = asked(scratch, browser, R"js(
    perp.seek(1); out.names = perp.bodies; out.z = perp.bodies.map(n => perp.pose(n).position[2]);
    out.labels = Array.from(document.querySelectorAll('#labels span'), s => s.textContent);
    out.title = document.getElementById('title').textContent; out.tab = document.title;
    out.button = document.querySelector('#events button').textContent; out.images = document.images.length;)js",
                         "");
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(out["names"][i] == names[i]);
    CHECK(out["labels"][i] == names[i]);
    CHECK(out["z"][i] == 1);
  }
  CHECK(out["title"] == run.name);
  CHECK(out["tab"] == run.name);
  CHECK(out["button"].get<std::string>().find("<img src=x onerror=throw>") != std::string::npos);
  CHECK(out["images"] == 0);
}

}  // namespace
}  // namespace perp
