#include "drivers/trig_polynomial.hpp"

#include <limits>

namespace shaker {

namespace {

// Cells narrower than this, in rad, count as monotone. Reached only where f, f' and f'' vanish together.
constexpr double narrowest = 1e-6;
constexpr double flat = 1e-200;  // below this the bounds would underflow

/// Newton's method with bisection as fallback; f(a) and f(b) differ in sign.
double bracketed_root(const TrigPolynomial& f, const TrigPolynomial& slope, double a, double b,
                      bool negative_at_a) {
    double x = (a + b) / 2;
    for (int i = 0; i < 200; ++i) {
        const Turn z = turn(x);
        const double y = f(z);
        if (y == 0) return x;
        ((y < 0) == negative_at_a ? a : b) = x;
        double next = x - y / slope(z);
        if (!(next > a && next < b)) next = (a + b) / 2;
        if (std::abs(next - x) <= std::numeric_limits<double>::epsilon() * std::abs(x)) return next;
        x = next;
    }
    return x;
}

/// Divides the circle into cells on which f is provably monotone and collects the sign changes of f.
class SignChangeSearch {
public:
    explicit SignChangeSearch(const TrigPolynomial& f)
        : f_{f}, d1_{f.derivative()}, d2_{d1_.derivative()}, bound_{f.bound(1), f.bound(2), f.bound(3)} {
        const int cells = 4 * f.order;
        double left = f(0.0);
        for (int i = 0; i < cells; ++i) {
            // The last cell uses the value at phase 0, so that a root at the seam counts once.
            const double b = two_pi * (i + 1) / cells, right = i + 1 == cells ? f(0.0) : f(b);
            search(two_pi * i / cells, left, b, right);
            left = right;
        }
    }
    [[nodiscard]] const std::vector<double>& roots() const noexcept { return roots_; }

private:
    void search(double a, double fa, double b, double fb) {
        const double mid = (a + b) / 2, half = (b - a) / 2;
        const Turn z = turn(mid);
        const double f_mid = f_(z);
        if (std::abs(f_mid) > bound_[0] * half) return;
        if (std::abs(d1_(z)) > bound_[1] * half || half < narrowest) return add_monotone(a, fa, b, fb);
        if (std::abs(d2_(z)) > bound_[2] * half) {
            const double da = d1_(a), db = d1_(b);
            if ((da < 0) == (db < 0)) return add_monotone(a, fa, b, fb);
            const double extremum = bracketed_root(d1_, d2_, a, b, da < 0), value = f_(extremum);
            add_monotone(a, fa, extremum, value);
            return add_monotone(extremum, value, b, fb);
        }
        search(a, fa, mid, f_mid);
        search(mid, f_mid, b, fb);
    }
    void add_monotone(double a, double fa, double b, double fb) {
        if ((fa < 0) == (fb < 0)) return;
        const double root = bracketed_root(f_, d1_, a, b, fa < 0);
        roots_.push_back(root < two_pi ? root : 0.0);
    }

    const TrigPolynomial& f_;
    TrigPolynomial d1_, d2_;
    std::array<double, 3> bound_;
    std::vector<double> roots_;
};

}  // namespace

TrigPolynomial::TrigPolynomial(double mean_value,
                               const std::array<std::complex<double>, max_harmonics>& a) noexcept
    : mean{mean_value} {
    for (std::size_t q = 0; q < a.size(); ++q) {
        in_phase[q] = a[q].real();
        quadrature[q] = a[q].imag();
        if (a[q] != 0.0) order = static_cast<int>(q) + 1;
    }
}

TrigPolynomial TrigPolynomial::derivative() const noexcept {
    TrigPolynomial d;
    d.order = order;
    for (std::size_t i = 0; i < in_phase.size(); ++i) {
        const double q = static_cast<double>(i) + 1;
        d.in_phase[i] = -q * quadrature[i];
        d.quadrature[i] = q * in_phase[i];
    }
    return d;
}

double TrigPolynomial::bound(int n) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < in_phase.size(); ++i) {
        sum += std::pow(static_cast<double>(i) + 1, n) * std::hypot(in_phase[i], quadrature[i]);
    }
    return sum;
}

std::vector<double> sign_changes(const TrigPolynomial& f) {
    if (const double reach = f.bound(0); reach < std::abs(f.mean) || reach < flat) return {};
    std::vector<double> roots = SignChangeSearch{f}.roots();
    // A root at the seam is found last but belongs to the front.
    if (!roots.empty() && roots.back() == 0) {
        roots.pop_back();
        roots.insert(roots.begin(), 0.0);
    }
    return roots;
}

}  // namespace shaker
