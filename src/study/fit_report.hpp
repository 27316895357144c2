// What a fit says at its end.
#pragma once

#include "study/fit_adjust.hpp"

namespace perp {

void report_values(FitAdjuster& adjuster, FitResult& result);
/// Of the motions fitted to; the last rows of a motion alone were held back.
void report_residuals(FitAdjuster& adjuster, FitResult& result);
/// Motions that had no part: their starts from their rows before the first contact, all else as fitted.
void predict(const FitProblem& problem, const std::vector<MeasuredMotion>& held, const Unknowns& fitted,
             const Vector& theta, const Vector& sigma, const std::vector<std::string>& columns,
             FitResult& result);

}  // namespace perp
