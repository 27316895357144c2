// The unknowns of a fit as one vector: what each is, where it enters, what is natural for it.
#pragma once

#include <string>
#include <vector>

#include "perp/study/fit.hpp"

namespace perp {

enum class UnknownKind {
  Parameter,
  ClockOffset,
  ClockRate,
  Shift,
  Turn,
  Scale,
  Coordinate,
  Rate,
  Rotation,
  Spin
};

struct Unknown {
  std::string name;  ///< without the motion
  UnknownKind kind;
  int motion = -1;   ///< whose it is; -1: of all
  BodyId body = {};  ///< of Rotation and Spin
  int index = 0;     ///< in q, in nu, or of an axis
  double low = -infinity, high = infinity;
  double guess = 0;
  double scale = 1;  ///< a change of it that matters, in its unit
  bool shared() const { return motion < 0; }
};

/// Where a motion's free starts are counted from.
struct StartBase {
  std::vector<std::pair<BodyId, Quaternion>> orientations = {};
};

/// How the data's clock and frame differ from the model's.
struct Recording {
  double offset = 0, rate = 1;
  Vector3 shift = Vector3::Zero(), turn = Vector3::Zero();
  double scale = 1;
};

class Unknowns {
 public:
  /// Reads the names; throws std::invalid_argument for one that means nothing here. Guesses are the scene's own.
  Unknowns(const FitProblem& problem, const Scene& scene, const std::vector<MeasuredMotion>& motions);

  int size() const { return static_cast<int>(all_.size()); }
  Unknown& operator[](int i) { return all_[static_cast<std::size_t>(i)]; }
  const Unknown& operator[](int i) const { return all_[static_cast<std::size_t>(i)]; }
  /// Those that motion i depends on, in their order.
  std::vector<int> of(int motion) const;
  bool whole_rotation(int motion, BodyId body) const;  ///< whether all three of a start's rotation are free

  SceneParameters parameters(const SceneParameters& set, const Vector& theta) const;
  Recording recording(int motion, const Vector& theta) const;
  /// The start of a motion: the scene's with what is free changed.
  State start(const Scene& scene, int motion, const Vector& theta) const;

  std::vector<StartBase> bases;  ///< of each motion

 private:
  void add_start(const FreeQuantity& free, const Model& model, BodyId body, const std::string& part,
                 int motions);

  std::vector<Unknown> all_;
};

}  // namespace perp
