// MuJoCo: elliptic (elliptic cones, Newton), pyramidal; rk4 (its fourth-order integrator), for what has no contact.
#include <mujoco/mujoco.h>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "engine.hpp"

namespace peers {
namespace {

std::string numbers(std::initializer_list<double> entries) {
  std::string text;
  char number[32];
  for (const double x : entries) {
    std::snprintf(number, sizeof number, "%.17g ", x);
    text += number;
  }
  return "'" + text + "'";
}

std::string text_of(const Scene& s, const std::string& configuration, double h) {
  const bool chain = !s.hinges.empty();
  const auto vec = [](const Vec& a) { return numbers({a[0], a[1], a[2]}); };
  std::string text =
      "<mujoco><compiler autolimits='true'/><option timestep=" + numbers({h}) + " gravity=" + vec(s.gravity) +
      " solver='Newton' cone='" + (configuration == "pyramidal" ? "pyramidal" : "elliptic") +
      "' integrator='" + (configuration == "rk4" ? "RK4" : "Euler") + "'/>" +
      "<size nconmax='1000' njmax='4000'/>" +  // its own guess drops contacts of a stack that falls
      "<default><geom condim='3' friction=" + numbers({s.mu, 0, 0}) + "/></default><worldbody>";
  if (s.floor) text += "<geom type='plane' size='0 0 1'/>";
  Vec parent_x{};
  Quat parent_q{1, 0, 0, 0};
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    const Body& b = s.bodies[i];
    const Vec x = chain ? turned_back(parent_q, b.x - parent_x) : b.x;
    const Quat q = chain && i > 0 ? Quat{1, 0, 0, 0} : b.q;  // all rods start alike
    text += "<body pos=" + vec(x) + " quat=" + numbers({q[0], q[1], q[2], q[3]}) +
            "><inertial pos='0 0 0' mass=" + numbers({b.mass}) + " diaginertia=" + vec(b.inertia()) + "/>";
    if (chain)
      text += "<joint type='hinge' pos=" + vec(turned_back(b.q, s.hinges[i].anchor - b.x)) +
              " axis=" + vec(turned_back(b.q, s.hinges[i].axis)) + "/>";
    else
      text += "<freejoint/>";
    if (s.floor && b.sphere()) text += "<geom type='sphere' size=" + numbers({b.radius}) + "/>";
    if (s.floor && !b.sphere()) text += "<geom type='box' size=" + vec(b.half) + "/>";
    if (!chain) text += "</body>";
    parent_x = b.x, parent_q = b.q;
  }
  for (std::size_t i = 0; chain && i < s.bodies.size(); ++i) text += "</body>";
  return text + "</worldbody></mujoco>";
}

class MujocoWorld final : public World {
 public:
  MujocoWorld(const Scene& s, const std::string& configuration, double h) : chain_(!s.hinges.empty()) {
    const std::string text = text_of(s, configuration, h);
    auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "scene.xml", int(text.size()));
    std::memcpy(files->filedata[0], text.data(), text.size());
    char error[1000] = "";
    model_ = mj_loadXML("scene.xml", files.get(), error, sizeof error);
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(error);
    data_ = mj_makeData(model_);
    for (std::size_t i = 0; !chain_ && i < s.bodies.size(); ++i) {
      const Body& b = s.bodies[i];
      const Vec w = turned_back(b.q, b.w);
      for (std::size_t k = 0; k < 3; ++k) data_->qvel[6 * i + k] = b.v[k], data_->qvel[6 * i + 3 + k] = w[k];
    }
  }
  ~MujocoWorld() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }

  void step() override { mj_step(model_, data_); }
  Vec centre(std::size_t body) override {
    mj_kinematics(model_, data_);
    const mjtNum* x = data_->xpos + 3 * (body + 1);
    return {x[0], x[1], x[2]};
  }

 private:
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  bool chain_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(
      argc, argv, "MuJoCo", PEER_VERSION,
      [](const peers::Scene& s, const std::string& c, double h) -> std::unique_ptr<peers::World> {
        if (c == "rk4" && s.floor) return nullptr;
        return std::make_unique<peers::MujocoWorld>(s, c, h);
      });
}
