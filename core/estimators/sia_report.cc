#include "core/estimators/sia_report.h"

#include <cmath>
#include <limits>

namespace faultlab::core {

bool SiaExactMap::Apply(const double* inverse,
                        double variance,
                        double* theta,
                        double* sigma) const {
  const double t = period_s;
  const double b0 = theta[0];
  const double b1p = theta[1];
  const double a1p = theta[2];
  if (!(a1p > t)) {
    const double reach = a1p + sigma[2];
    theta[1] = theta[2] = 0.0;
    sigma[1] = std::numeric_limits<double>::infinity();
    sigma[2] = reach > t ? -t / std::log(1.0 - t / reach) : 0.0;
    return false;
  }
  // Besides log and exp, divisions cost the most here, so reciprocals are shared.
  const double per_a1p = 1.0 / a1p;
  const double pole = 1.0 - t * per_a1p;  // exp(-T/a1)
  const double log_pole = std::log(pole);
  if (!(log_pole < 0.0)) {
    return false;  // a1' beyond 1e14 T is an integrator in double precision: only theta' is known
  }
  const double a1 = -t / log_pole;
  const double rate = -log_pole / t;  // 1/a1
  const double b0d = b1p * per_a1p;
  const double growth = delta_s == 0.0 ? 1.0 : std::exp(delta_s * rate);
  const double grown = (b0 - b0d) * growth;
  const double b1_over_a1 = b0 - grown;
  const double b1 = a1 * b1_over_a1;
  // d a1 / d a1' = (a1/a1')^2 / (1 - T/a1');  d growth / d a1 = -growth delta / a1^2.
  const double share = a1 * per_a1p;
  const double da1 = share * share / pole;
  const double db1_db0 = a1 * (1.0 - growth);
  const double db1_db1p = share * growth;
  const double db1_da1p = (b1_over_a1 + grown * delta_s * rate) * da1 - db1_db1p * b0d;
  // Packed inverse: (0,0) (1,0) (1,1) (2,0) (2,1) (2,2).
  const double b1_variance =
      variance * (db1_db0 * db1_db0 * inverse[0] + db1_db1p * db1_db1p * inverse[2] +
                  db1_da1p * db1_da1p * inverse[5] +
                  2.0 * (db1_db0 * db1_db1p * inverse[1] + db1_db0 * db1_da1p * inverse[3] +
                         db1_db1p * db1_da1p * inverse[4]));
  theta[1] = b1;
  theta[2] = a1;
  sigma[1] = std::sqrt(b1_variance > 0.0 ? b1_variance : 0.0);
  sigma[2] *= da1;
  return true;
}

}  // namespace faultlab::core
