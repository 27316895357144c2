// Smaller scenes that still fail.
#include <cmath>

#include "trial.hpp"

namespace checker {

RandomScene begun_at(const RandomScene& random, const State& x) {
  RandomScene begun = random;
  for (std::size_t i = 1; i < begun.scene.bodies.size(); ++i) {
    Body& b = begun.scene.bodies[i];
    if (!b.moves()) continue;
    b.starts_elsewhere = true;
    b.start = x.bodies[i].at;
    b.start_angle = x.bodies[i].angle;
    b.v = x.bodies[i].v;
    b.w = x.bodies[i].w;
  }
  return begun;
}

namespace {

using Change = std::function<bool(RandomScene&)>;  // false: nothing to change

template <class Things, class Tied>
void erase_if_tied(Things& things, Tied tied) {
  std::erase_if(things, tied);
}

void remove_joint(Scene& s, int j) {
  const auto of = [j](const auto& thing) { return thing.joint == j; };
  std::erase_if(s.limits, of);
  std::erase_if(s.motors, of);
  std::erase_if(s.joint_springs, of);
  const auto renumber = [j](auto& things) {
    for (auto& thing : things)
      if (thing.joint > j) --thing.joint;
  };
  renumber(s.limits);
  renumber(s.motors);
  renumber(s.joint_springs);
  s.joints.erase(s.joints.begin() + j);
}

void remove_body(Scene& s, int b) {
  for (int j = static_cast<int>(s.joints.size()) - 1; j >= 0; --j)
    if (const Joint& joint = s.joints[static_cast<std::size_t>(j)]; joint.a == b || joint.b == b)
      remove_joint(s, j);
  const auto of = [b](const auto& thing) { return thing.a == b || thing.b == b; };
  std::erase_if(s.contacts, of);
  std::erase_if(s.springs, of);
  std::erase_if(s.forces, [b](const Force& f) { return f.body == b; });
  const auto renumber = [b](auto& things) {
    for (auto& thing : things) {
      if (thing.a > b) --thing.a;
      if (thing.b > b) --thing.b;
    }
  };
  renumber(s.joints);
  renumber(s.contacts);
  renumber(s.springs);
  for (Force& f : s.forces)
    if (f.body > b) --f.body;
  s.bodies.erase(s.bodies.begin() + b);
}

double plain(double x, int figures) {
  if (x == 0 || !std::isfinite(x)) return x;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) - figures + 1);
  return std::strtod(digits(std::round(x / unit) * unit).c_str(), nullptr);
}

void plain(Vector3d& v, int figures) {
  for (double& x : v) x = plain(x, figures);
}

std::vector<Change> changes(const Scene& s) {
  std::vector<Change> all;
  const auto leave_out = [&](auto member) {
    for (int i = static_cast<int>((s.*member).size()) - 1; i >= 0; --i)
      all.emplace_back([member, i](RandomScene& r) {
        auto& things = r.scene.*member;
        if (i >= static_cast<int>(things.size())) return false;
        things.erase(things.begin() + i);
        return true;
      });
  };
  for (int i = static_cast<int>(s.bodies.size()) - 1; i > 0; --i)
    all.emplace_back([i](RandomScene& r) {
      if (i >= static_cast<int>(r.scene.bodies.size()) || r.scene.bodies.size() <= 2) return false;
      remove_body(r.scene, i);
      return true;
    });
  for (int i = static_cast<int>(s.joints.size()) - 1; i >= 0; --i)
    all.emplace_back([i](RandomScene& r) {
      if (i >= static_cast<int>(r.scene.joints.size())) return false;
      remove_joint(r.scene, i);
      return true;
    });
  leave_out(&Scene::contacts);
  leave_out(&Scene::forces);
  leave_out(&Scene::springs);
  leave_out(&Scene::motors);
  leave_out(&Scene::limits);
  leave_out(&Scene::joint_springs);
  all.emplace_back([](RandomScene& r) { return r.steps > 1 && (r.steps = 1) == 1; });
  all.emplace_back([](RandomScene& r) { return r.steps > 1 && --r.steps > 0; });
  for (std::size_t i = 1; i < s.bodies.size(); ++i) {
    const auto body = [i](auto change) {
      return [i, change](RandomScene& r) { return i < r.scene.bodies.size() && change(r.scene.bodies[i]); };
    };
    all.emplace_back(body([](Body& b) { return !b.w.isZero(0) && (b.w.setZero(), true); }));
    all.emplace_back(body([](Body& b) { return !b.v.isZero(0) && (b.v.setZero(), true); }));
    all.emplace_back(body([](Body& b) {
      return b.mass > 0 && b.mass != 1 && b.shape != "moments" && b.kind != Kind::Planar && (b.mass = 1) == 1;
    }));
    for (const int figures : {1, 3})
      all.emplace_back(body([figures](Body& b) {
        const Vector3d v = b.v, w = b.w;
        plain(b.v, figures);
        plain(b.w, figures);
        const double mass = b.mass;
        b.mass = plain(b.mass, figures);
        return v != b.v || w != b.w || mass != b.mass;
      }));
  }
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const auto contact = [i](auto change) {
      return
          [i, change](RandomScene& r) { return i < r.scene.contacts.size() && change(r.scene.contacts[i]); };
    };
    all.emplace_back(contact([](Contact& c) { return c.mu != 0 && ((c.mu = 0), true); }));
    all.emplace_back(contact([](Contact& c) { return c.mu != 0 && c.mu != 0.5 && ((c.mu = 0.5), true); }));
    all.emplace_back(contact([](Contact& c) { return c.e != 0 && ((c.e = 0), true); }));
    all.emplace_back(contact([](Contact& c) { return !c.tangent.isZero(0) && (c.tangent.setZero(), true); }));
  }
  all.emplace_back([](RandomScene& r) {
    const double h = plain(r.h, 1);
    return h != r.h && (r.h = h) > 0;
  });
  return all;
}

}  // namespace

RandomScene shrink(const RandomScene& random, const std::function<bool(const RandomScene&)>& fails) {
  RandomScene least = random;
  int tries = 400;
  for (bool smaller = true; smaller && tries > 0;) {
    smaller = false;
    for (const Change& change : changes(least.scene)) {
      RandomScene next = least;
      if (!change(next) || --tries < 0 || !fails(next)) continue;
      least = next;
      smaller = true;
    }
  }
  return least;
}

}  // namespace checker
