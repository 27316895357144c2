// Bennett's linkage: a closed loop of four revolute joints in space that by counting could not move, and does.
#include <array>
#include <boost/math/differentiation/autodiff.hpp>
#include <cmath>

#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// A number that depends on the crank angle, with its first two derivatives.
using Jet = boost::math::differentiation::autodiff_fvar<Real, 2>;

/// A frame as a function of the crank angle, built up like Denavit and Hartenberg's: turn about z, go along x, twist about x.
struct JetFrame {
  std::array<std::array<Jet, 3>, 3> R{
      {{Jet(1), Jet(0), Jet(0)}, {Jet(0), Jet(1), Jet(0)}, {Jet(0), Jet(0), Jet(1)}}};
  std::array<Jet, 3> p{Jet(0), Jet(0), Jet(0)};

  JetFrame turned(const Jet& angle) const { return mixed(0, 1, cos(angle), sin(angle)); }
  JetFrame twisted(Real angle) const { return mixed(1, 2, Jet(std::cos(angle)), Jet(std::sin(angle))); }
  JetFrame shifted(Real length) const {
    JetFrame out = *this;
    for (std::size_t i = 0; i < 3; ++i) out.p[i] += length * R[i][0];
    return out;
  }

  /// The derivative of that order with respect to the crank angle.
  RealVector3 place(std::size_t derivative) const {
    return {p[0].derivative(derivative), p[1].derivative(derivative), p[2].derivative(derivative)};
  }
  Eigen::Matrix<Real, 3, 3> rotation(std::size_t derivative) const {
    Eigen::Matrix<Real, 3, 3> out;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        out(Eigen::Index(i), Eigen::Index(j)) = R[i][j].derivative(derivative);
    return out;
  }

 private:
  JetFrame mixed(std::size_t j, std::size_t k, const Jet& c,
                 const Jet& s) const {  // a turn from axis j to axis k
    JetFrame out = *this;
    for (std::size_t i = 0; i < 3; ++i) {
      out.R[i][j] = c * R[i][j] + s * R[i][k];
      out.R[i][k] = c * R[i][k] - s * R[i][j];
    }
    return out;
  }
};

/// Opposite links are alike, of lengths a, b and twists alpha, beta with sin(alpha)/a = sin(beta)/b; the frame is one of the
/// b links. Opposite angles add up to a whole turn, and neighbours obey
///   tan(theta1/2) tan(theta2/2) = sin((beta + alpha)/2)/sin((beta - alpha)/2)          [Ben03]
struct Bennett {
  Real a = 0.5L, alpha = std::numbers::pi_v<Real> / 6, beta = 7 * std::numbers::pi_v<Real> / 18;
  Real b = a * std::sin(beta) / std::sin(alpha);

  /// Frames of the three moving links (at their middles) and of the joint that closes the loop.
  std::array<JetFrame, 4> frames(Real crank) const {
    const Jet theta1 = boost::math::differentiation::make_fvar<Real, 2>(crank);
    const Real K = std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2);
    const Jet theta2 = 2 * atan2(K * cos(theta1 / 2), sin(theta1 / 2));
    const JetFrame first = JetFrame().turned(theta1);
    const JetFrame second = first.shifted(a).twisted(alpha).turned(theta2);
    const JetFrame third = second.shifted(b).twisted(beta).turned(-theta1);
    return {first.shifted(a / 2), second.shifted(b / 2), third.shifted(a / 2),
            third.shifted(a).twisted(alpha)};
  }
};

/// theta'' of bodies of 1 kg with the pseudo-inertia P = tr(J)/2 - J, from I theta'' + (1/2) I' theta'^2 = -V' with
///   I = sum |p'|^2 + tr(R' P R'^T),   V = sum g p_z.
Real acceleration(const std::array<JetFrame, 4>& frames, const std::array<RealVector3, 3>& P, Real rate) {
  Real I = 0, half_slope = 0, slope = 0;
  for (std::size_t i = 0; i < P.size(); ++i) {
    const auto R1 = frames[i].rotation(1), R2 = frames[i].rotation(2);
    I += frames[i].place(1).squaredNorm() + (R1 * P[i].asDiagonal() * R1.transpose()).trace();
    half_slope +=
        frames[i].place(1).dot(frames[i].place(2)) + (R1 * P[i].asDiagonal() * R2.transpose()).trace();
    slope += g * frames[i].place(1).z();
  }
  return -(slope + half_slope * rate * rate) / I;
}

}  // namespace

Scene bennett(Parameters& set) {
  const double rate0 = set.number("rate", 3, "initial rate of the crank [rad/s]");
  const Real theta0 = pi / 3;
  Scene s;
  s.id = "C4";
  s.what = "Bennett's linkage: four revolute joints in space whose axes and lengths just let it move";
  s.t_end = 2;
  const Bennett linkage;
  const std::array<JetFrame, 4> start = linkage.frames(theta0);
  const std::array<const char*, 3> names{"crank", "coupler", "rocker"};
  std::array<RealVector3, 3> P;
  std::array<BodyId, 3> bodies;
  const auto pose = [](const JetFrame& frame) {
    return Pose{frame.place(0).cast<double>(),
                Quaternion(Eigen::Quaternion<Real>(frame.rotation(0)).normalized().cast<double>())};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 size(double(i == 1 ? linkage.b : linkage.a), 0.05, 0.05);
    bodies[i] = s.model.add_body(Inertia::solid_box(1, size), {.pose = pose(start[i]), .name = names[i]});
    P[i] = size.cast<Real>().cwiseAbs2() / 12;
  }
  // each joint turns about the z axis of the link behind it, at that link's end
  const auto axis = [&](const JetFrame& link, Real behind) {
    const JetFrame joint = link.shifted(-behind);
    return JointOptions{.point = joint.place(0).cast<double>(),
                        .axis = joint.rotation(0).col(2).cast<double>()};
  };
  s.model.add_joint(revolute(ground, bodies[0], axis(start[0], linkage.a / 2)));
  s.model.add_joint(revolute(bodies[0], bodies[1], axis(start[1], linkage.b / 2)));
  s.model.add_joint(revolute(bodies[1], bodies[2], axis(start[2], linkage.a / 2)));
  s.model.add_joint(revolute(ground, bodies[2], axis(start[3], 0)));
  const auto place = [=](const Model& model, State& x, Real theta, Real rate) {
    const std::array<JetFrame, 4> now = linkage.frames(theta);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Matrix<Real, 3, 3> spin = rate * now[i].rotation(1) * now[i].rotation(0).transpose();
      const RealVector3 w(spin(2, 1), spin(0, 2), spin(1, 0));
      const Pose X = pose(now[i]);
      model.set_position(x, bodies[i], X.p);
      model.set_orientation(x, bodies[i], X.q);
      model.set_velocity(x, bodies[i], (rate * now[i].place(1)).cast<double>(), w.cast<double>());
    }
  };
  s.start = s.model.rest();
  place(s.model, s.start, theta0, rate0);

  const auto rates = [=](Real, const Reals& y, Reals& dy) {
    dy = {y[1], acceleration(linkage.frames(y[0]), P, y[1])};
  };
  const ReferenceMotion motion(rates, {theta0, rate0});
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Reals y = motion.at(t).y;
    place(model, x, y[0], y[1]);
  });
  return s;
}

}  // namespace perp
