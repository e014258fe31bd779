#include "core/estimators/sliding_integral.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace faultlab::core {
namespace {

std::vector<double> RandomSignal(int samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> value(1.0, 2.0);
  std::vector<double> x;
  for (int k = 0; k < samples; ++k) {
    x.push_back(value(random));
  }
  return x;
}

std::vector<double> Multiply(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> product(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      product[i + j] += a[i] * b[j];
    }
  }
  return product;
}

/// The coefficients of T^(n-j) Q^(n-j) (1 - z^-m)^j in powers of z^-1, by polynomial products.
std::vector<double> RhoPolynomial(int order, int j, int length, double period_s) {
  std::vector<double> q(static_cast<std::size_t>(length) + 1, period_s);
  q[0] = 0.0;
  std::vector<double> d(static_cast<std::size_t>(length) + 1, 0.0);
  d.front() = 1.0;
  d.back() = -1.0;
  std::vector<double> rho = {1.0};
  for (int i = 0; i < order - j; ++i) {
    rho = Multiply(rho, q);
  }
  for (int i = 0; i < j; ++i) {
    rho = Multiply(rho, d);
  }
  return rho;
}

double Filter(const std::vector<double>& rho, const std::vector<double>& x, std::size_t k) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rho.size() && i <= k; ++i) {
    sum += rho[i] * x[k - i];
  }
  return sum;
}

template <int Order>
void ExpectPolynomials(int length) {
  const std::vector<double> x = RandomSignal(200, static_cast<std::uint64_t>(length));
  NestedIntegrals<Order> nested(length, 0.01);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const std::array<double, Order + 1> rho = nested.Push(x[k]);
    for (int j = 0; j <= Order; ++j) {
      ASSERT_NEAR(rho[static_cast<std::size_t>(j)],
                  Filter(RhoPolynomial(Order, j, length, 0.01), x, k),
                  1e-11)
          << "order " << Order << " j " << j << " m " << length << " k " << k;
    }
  }
}

TEST(NestedIntegrals, EqualThePolynomialsOfThePaperForOrdersOneToThree) {
  for (int length : {1, 5, 20}) {
    ExpectPolynomials<1>(length);
    ExpectPolynomials<2>(length);
    ExpectPolynomials<3>(length);
  }
}

TEST(NestedIntegrals, IntegrateADerivativeExactly) {
  // x = t^2: the double integral of x'' = 2 over (m T)^2 is (1 - z^-m)^2 x = 2 (m T)^2.
  NestedIntegrals<2> nested(5, 0.01);
  double second_difference = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double t = 0.01 * k;
    second_difference = nested.Push(t * t)[2];
  }
  EXPECT_NEAR(second_difference, 2.0 * 0.05 * 0.05, 1e-15);
}

TEST(SlidingIntegral, DoesNotDriftOverAMillionSamplesAndForgetsAGlitch) {
  const int m = 20;
  SlidingIntegral integral(m);
  const std::vector<double> x = RandomSignal(1000, 3);
  integral.Push(1e12);
  double last = 0.0;
  std::size_t k = 0;
  for (int n = 0; n < 1'000'000; ++n) {
    k = static_cast<std::size_t>(n) % x.size();
    last = integral.Push(x[k]).integral;
  }
  double batch = 0.0;
  for (std::size_t i = 1; i <= m; ++i) {
    batch += x[k - i];
  }
  EXPECT_NEAR(last, batch, 1e-12);
}

TEST(SlidingIntegral, RefusesALengthOfZero) {
  EXPECT_THROW(SlidingIntegral(0), ContractError);
}

}  // namespace
}  // namespace faultlab::core
