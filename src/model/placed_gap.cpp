// Gaps between shapes that do not sit at their bodies' origins.
#include "model/gap_maker.hpp"

namespace perp {
namespace {

/// Of a shape's twist (v_S, w_S) to its body's: w_S = w, v_S = v + w x r with r = R p_BS, so that the columns of w gain -D_v [r]x.
void carry_over(ContactDerivative::Columns& columns, const Vector3& r_A, const Vector3& r_B) {
  w_A(columns) -= v_A(columns) * skew(r_A);
  w_B(columns) -= v_B(columns) * skew(r_B);
}

}  // namespace

Gap placed(const Gap& gap, const Pose& X_AS, const Pose& X_BS) {
  for (const Pose& X : {X_AS, X_BS})
    if (!X.p.allFinite() || !X.q.coeffs().allFinite())
      refuse("placed", "place", "not finite", "needs finite entries");
  const Pose in_a{X_AS.p, unit(X_AS.q)}, in_b{X_BS.p, unit(X_BS.q)};
  Gap moved =
      Gap::patch(gap.points(), [=](const Pose& X_WA, const Pose& X_WB, double t,
                                   std::span<ContactPoint> out) { gap(X_WA * in_a, X_WB * in_b, t, out); });
  if (gap.has_derivatives())
    moved.differentiated_by(
        [=](const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out) {
          gap.differentiate(X_WA * in_a, X_WB * in_b, t, out);
          const Vector3 r_A = X_WA.q * in_a.p, r_B = X_WB.q * in_b.p;
          for (ContactDerivative& d : out) {
            carry_over(d.normal, r_A, r_B);
            carry_over(d.point, r_A, r_B);
          }
        });
  moved.levers(gap.lever_a() + in_a.p.norm(), gap.lever_b() + in_b.p.norm());
  Recipe recipe = gap.recipe();
  if (recipe.places.empty())
    recipe.places = {in_a, in_b};
  else
    recipe = {};  // placed twice: no file can say
  return moved.made_by(recipe);
}

}  // namespace perp
