// What the exam's questions are written with.
#pragma once

#include <cmath>

#include "perp/io/exam.hpp"

namespace perp::exam {

inline constexpr double deg = M_PI / 180;

inline ExamQuantity error(double t, double tolerance) { return {"error", t, 0, tolerance}; }
inline ExamQuantity moved(double t, double tolerance) { return {"moved", t, 0, tolerance}; }
inline ExamQuantity goes(double t, double least) { return {"moved", t, least, 0, ExamRule::AtLeast}; }
inline ExamQuantity near(const char* what, double t, double right, double tolerance) {
  return {what, t, right, tolerance};
}
inline ExamQuantity most(const char* what, double t, double tolerance) {
  return {what, t, 0, tolerance, ExamRule::AtMost};
}

[[nodiscard]] std::vector<ExamQuestion> impacts();
[[nodiscard]] std::vector<ExamQuestion> where_methods_fail();

}  // namespace perp::exam
