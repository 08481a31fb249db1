#include "daemon/law/law_fit.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <numeric>

#include "daemon/law/least_squares.hpp"
#include "drivers/errors.hpp"

namespace shaker::law {

namespace {

constexpr int first_pushed = 9;  // lowest harmonic that the drive does not control
constexpr double least_mu = 0.01, largest_mu = 1.5, log_mu_step = 1e-3, tilt_by = 1e-5;
constexpr double rough_tolerance = 1e-8,
                 fine_tolerance = 1e-10;  // tolerance of the integrator: in the fit, at its end
constexpr double law_error = 1e-6;        // of gamma/omega, of v_D by the law in the fit
constexpr int most_steps = 40, start_steps = 5, most_dampings = 8;
constexpr double first_damping = 1e-3, least_damping = 1e-6;
constexpr std::size_t start_points = 12;
constexpr double stands_still = 0.01;  // of the standard errors
constexpr double negligible = 0.01;    // change of chi^2
constexpr double far = 1.5;            // largest factor of mu in one step
constexpr double most_push = 0.5;

/// A free quantity of the fit.
struct Free {
    std::string_view name, unit;
    double low, high, step;
    bool logarithmic;
    void (*set)(LawSetting&, double);

    [[nodiscard]] double value(double y) const { return logarithmic ? std::exp(y) : y; }
    [[nodiscard]] double inner(double x) const { return logarithmic ? std::log(x) : x; }
    [[nodiscard]] double clamped(double y) const { return std::clamp(y, inner(low), inner(high)); }
};

class LawSearch {
public:
    LawSearch(const Law& law, const LawData& data, std::vector<std::size_t> used)
        : law_{law}, data_{data}, used_{std::move(used)} {
        free_.push_back({"mu", "1", least_mu, largest_mu, log_mu_step, true,
                         [](LawSetting& s, double x) { s.friction.mu_k = x; }});
        for (const LawParameter& p : law.parameters)
            free_.push_back({p.name, p.unit, p.low, p.high, p.step, p.logarithmic, p.set});
        if (data.free_tilt)
            free_.push_back(
                {"tilt", "rad", -0.5, 0.5, tilt_by, false, [](LawSetting& s, double x) { s.tilt = x; }});
        double places = 0, known = 0;
        for (const Point& p : data.points) {
            first_s_ = std::fmin(first_s_, p.time_s);
            if (std::isfinite(p.place)) places += p.place, known += 1;
        }
        base_.middle = known > 0 ? places / known : 0;
        const Coulomb& c = data.coulomb->law;
        base_.friction.law = law.friction;
        base_.tilt = c.tilt;
        base_.g = c.g;
        base_.push = c.push;
        x_.push_back(free_[0].inner(c.mu));
        for (const LawParameter& p : law.parameters)
            x_.push_back(p.logarithmic ? std::log(p.starts[0]) : p.starts[0]);
        if (data.free_tilt) x_.push_back(c.tilt);
        harmonics_ = data.harmonics && std::ranges::any_of(data.points, [](const Point& p) {
                         return std::ranges::any_of(p.base_sd.begin() + first_pushed - 1, p.base_sd.end(),
                                                    [](double sd) { return sd > 0; });
                     });
    }

    /// Begins with this value of one of the law's parameters.
    void start(std::size_t parameter, double value) { x_[1 + parameter] = free_[1 + parameter].inner(value); }
    /// Begins where another search of the same law ended.
    void start(const LawSearch& other) { x_ = other.x_; }

    /// Searches in at most `rounds` steps. Returns chi^2. InputError where there is no settled motion.
    double search(int rounds) {
        tolerance_ = rough_tolerance;
        at_ = cycles(x_, nullptr);
        double best = HUGE_VAL;
        double damping = first_damping;
        for (int round = 0; round < rounds; ++round) {
            take_push();
            best = chi2_of(x_, at_);
            const Eigen::MatrixXd A = derivatives();
            std::vector<double> next;
            std::vector<LawCycle> there;
            double chi2 = HUGE_VAL;
            int turn = 0;
            for (; turn < most_dampings && !(chi2 <= best + negligible); ++turn) {
                next = moved(A, damping);
                chi2 = chi2_at(next, there);
                damping = chi2 <= best + negligible ? std::max(least_damping, 0.1 * damping) : 10 * damping;
            }
            if (!(chi2 <= best + negligible)) return best;
            const bool stands = change(A, next) < stands_still || (turn == 1 && best - chi2 < negligible);
            best = std::min(best, chi2);
            x_ = std::move(next);
            at_ = std::move(there);
            if (stands) return best;
        }
        ended_ = false;
        return best;
    }

    LawFit finished() {
        LawFit fit{.law = &law_};
        if (!ended_) fit.reason = "the fit did not converge";
        tolerance_ = fine_tolerance;
        take_push();
        const Eigen::MatrixXd A = derivatives();
        const Rows rows = rows_at(x_, at_);
        const Linear last = least_squares(A, rows.y, rows.sigma, Weights::by_error);
        fit.setting = setting(x_);
        fit.free = static_cast<int>(x_.size());
        for (std::size_t i = 0; i <= law_.parameters.size(); ++i) {
            const auto k = static_cast<Eigen::Index>(i);
            Fit f{.name = std::string{free_[i].name},
                  .value = free_[i].value(x_[i]),
                  .unit = std::string{free_[i].unit}};
            f.error = std::sqrt(last.covariance(k, k)) * (free_[i].logarithmic ? f.value : 1);
            if (A.col(k).isZero(0)) f.error = NAN;  // the points do not show it
            f.points = static_cast<int>(used_.size());
            (i == 0 ? fit.mu : fit.parameters.emplace_back()) = f;
            fit.covariance.names.push_back(f.name);
        }
        for (std::size_t i = 0; i < fit.covariance.names.size(); ++i)
            for (std::size_t j = 0; j < fit.covariance.names.size(); ++j) {
                const auto scale = [&](std::size_t k) {
                    return free_[k].logarithmic ? free_[k].value(x_[k]) : 1;
                };
                fit.covariance.values.push_back(
                    last.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * scale(i) *
                    scale(j));
            }
        if (data_.free_tilt)
            fit.tilt = {.name = "tilt",
                        .value = x_.back(),
                        .error = std::sqrt(last.covariance.diagonal().tail(1)[0]),
                        .unit = "rad"};
        fit.chi2 = rows.y.head(own_rows()).cwiseQuotient(rows.sigma.head(own_rows())).squaredNorm();
        fit.freedom = static_cast<int>(own_rows()) - fit.free;
        fit.chi2_base = rows.y.tail(rows.y.size() - own_rows())
                            .cwiseQuotient(rows.sigma.tail(rows.y.size() - own_rows()))
                            .squaredNorm();
        fit.freedom_base = harmonics_ ? known_harmonics() - 3 : 0;
        for (std::size_t i = 0; i < used_.size(); ++i)
            fit.z.push_back(rows.y[static_cast<Eigen::Index>(i)] / rows.sigma[static_cast<Eigen::Index>(i)]);
        return fit;
    }

private:
    struct Rows {
        Eigen::VectorXd y, sigma;  // measured - law, and its error
    };

    [[nodiscard]] LawSetting setting(const std::vector<double>& x) const {
        LawSetting s = base_;
        for (std::size_t i = 0; i < x.size(); ++i) free_[i].set(s, free_[i].value(x[i]));
        return s;
    }

    std::vector<LawCycle> cycles(const std::vector<double>& x, const std::vector<LawCycle>* near) {
        const LawSetting s = setting(x);
        std::vector<LawCycle> out;
        for (std::size_t i = 0; i < used_.size(); ++i) {
            const Point& p = data_.points[used_[i]];
            out.push_back(
                law_cycle(p, p.time_s - first_s_, s, tolerance_, near != nullptr ? &(*near)[i] : nullptr));
        }
        return out;
    }

    // Rows of v_D, and of the tilt by gravity.
    [[nodiscard]] Eigen::Index own_rows() const {
        return static_cast<Eigen::Index>(used_.size()) + (weighs_tilt() ? 1 : 0);
    }
    [[nodiscard]] bool weighs_tilt() const {
        return data_.free_tilt && std::isfinite(data_.tilt.value) && data_.tilt.sigma > 0;
    }

    [[nodiscard]] Rows rows_at(const std::vector<double>& x, const std::vector<LawCycle>& at) const {
        const Eigen::Index own = own_rows(), n = static_cast<Eigen::Index>(used_.size());
        const Eigen::Index each = 2 * (max_harmonics - first_pushed + 1);
        Rows rows{Eigen::VectorXd::Zero(own + (harmonics_ ? each * n : 0)),
                  Eigen::VectorXd::Ones(own + (harmonics_ ? each * n : 0))};
        for (Eigen::Index k = 0; k < n; ++k) {
            const std::size_t i = used_[static_cast<std::size_t>(k)];
            const Point& p = data_.points[i];
            const LawPoint& c = data_.coulomb->points[i];
            const double drag = data_.coulomb->law.drag;  // moves v_D by as much as under Coulomb's law
            const double damped = drag != 0 ? (c.v_D - c.cycle.v_D) * drag_ / drag : 0;
            rows.y[k] = p.v_D.value - at[static_cast<std::size_t>(k)].v_D - damped;
            rows.sigma[k] = std::hypot(p.v_D.sigma, c.base_error, law_error * velocity_scale(p));
        }
        if (weighs_tilt()) {
            rows.y[n] = data_.tilt.value - x.back();
            rows.sigma[n] = data_.tilt.sigma;
        }
        if (harmonics_) {
            const Base base = base_at(at);
            rows.y.tail(base.y.size()) = base.y - base.A * base.rsu;
        }
        return rows;
    }

    // Harmonics 9 to 16 over their errors, P_q = -(r + i s/q + u/q^2) a_w,q, with the best r, s, u.
    struct Base {
        Eigen::MatrixXd A;
        Eigen::VectorXd y;
        Eigen::Vector3d rsu;
    };
    [[nodiscard]] Base base_at(const std::vector<LawCycle>& at) const {
        const Eigen::Index n =
            2 * (max_harmonics - first_pushed + 1) * static_cast<Eigen::Index>(used_.size());
        Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, 3);
        Eigen::VectorXd y = Eigen::VectorXd::Zero(n);
        Eigen::Index row = 0;
        for (std::size_t k = 0; k < used_.size(); ++k) {
            const Point& p = data_.points[used_[k]];
            for (int q = first_pushed; q <= max_harmonics; ++q, row += 2) {
                const double sd = p.base_sd[static_cast<std::size_t>(q - 1)];
                if (!(sd > 0)) continue;
                const std::complex<double> a = -at[k].walker[static_cast<std::size_t>(q - 1)] / sd,
                                           P = p.base.at(q) / sd,
                                           turned = a * std::complex<double>{0, 1.0 / q};
                A.row(row) << a.real(), turned.real(), a.real() / (q * q);
                A.row(row + 1) << a.imag(), turned.imag(), a.imag() / (q * q);
                y[row] = P.real();
                y[row + 1] = P.imag();
            }
        }
        return {A, y, (A.transpose() * A).ldlt().solve(A.transpose() * y)};
    }

    // Real and imaginary parts with errors.
    [[nodiscard]] int known_harmonics() const {
        int known = 0;
        for (const std::size_t i : used_)
            for (std::size_t q = first_pushed; q <= max_harmonics; ++q)
                known += data_.points[i].base_sd[q - 1] > 0 ? 2 : 0;
        return known;
    }

    // m/M_eff and the drag of the present cycles, and the cycles with them.
    void take_push() {
        if (harmonics_) {
            const Eigen::Vector3d rsu = base_at(at_).rsu;
            base_.push = std::clamp(rsu[0], 0.0, most_push);
            drag_ = rsu[0] > 0 ? rsu[1] : 0;
        }
        at_ = cycles(x_, &at_);
    }

    [[nodiscard]] double chi2_of(const std::vector<double>& x, const std::vector<LawCycle>& at) const {
        const Rows rows = rows_at(x, at);
        return rows.y.cwiseQuotient(rows.sigma).squaredNorm();
    }

    // The same, with the cycles at x, which it solves; infinite where there is no settled motion.
    double chi2_at(const std::vector<double>& x, std::vector<LawCycle>& there) {
        try {
            there = cycles(x, &at_);
            return chi2_of(x, there);
        } catch (const InputError&) {
            return HUGE_VAL;
        }
    }

    // Change of the law at all rows with each free quantity.
    Eigen::MatrixXd derivatives() {
        const Rows rows = rows_at(x_, at_);
        Eigen::MatrixXd A(rows.y.size(), static_cast<Eigen::Index>(x_.size()));
        for (std::size_t i = 0; i < x_.size(); ++i) {
            std::vector<double> beside = x_;
            double step = free_[i].step;
            if (free_[i].clamped(x_[i] + step) != x_[i] + step) step = -step;
            beside[i] += step;
            A.col(static_cast<Eigen::Index>(i)) = (rows.y - rows_at(beside, cycles(beside, &at_)).y) / step;
        }
        return A;
    }

    // The place with the least chi^2 of the law made linear, by Levenberg and Marquardt's damping. What would
    // leave its range goes to the end of it, and the others follow.
    [[nodiscard]] std::vector<double> moved(const Eigen::MatrixXd& derivatives, double damping) const {
        const Rows rows = rows_at(x_, at_);
        const Eigen::Index n = rows.y.size(), m = derivatives.cols();
        Eigen::MatrixXd A(n + m, m);
        A << rows.sigma.cwiseInverse().asDiagonal() * derivatives, Eigen::MatrixXd::Zero(m, m);
        for (Eigen::Index k = 0; k < m; ++k) A(n + k, k) = std::sqrt(damping) * A.col(k).head(n).norm();
        Eigen::VectorXd y(n + m);
        y << rows.y.cwiseQuotient(rows.sigma), Eigen::VectorXd::Zero(m);
        std::vector<double> next = x_;
        for (bool leaves = true; leaves;) {
            const Eigen::VectorXd step = A.completeOrthogonalDecomposition().solve(y);
            leaves = false;
            for (std::size_t i = 0; i < x_.size(); ++i) {
                const auto k = static_cast<Eigen::Index>(i);
                if (A.col(k).isZero(0)) continue;  // it stays at the end of its range
                const double low = i == 0 ? -std::log(far) : -HUGE_VAL;
                next[i] = free_[i].clamped(x_[i] + std::clamp(step[k], low, -low));
                if (next[i] == x_[i] + step[k]) continue;
                y -= A.col(k) * (next[i] - x_[i]);
                A.col(k).setZero();
                leaves = true;
                break;
            }
        }
        return next;
    }

    // Largest change of a free quantity, in its standard errors.
    [[nodiscard]] double change(const Eigen::MatrixXd& derivatives, const std::vector<double>& next) const {
        const Eigen::MatrixXd A = rows_at(x_, at_).sigma.cwiseInverse().asDiagonal() * derivatives;
        double largest = 0;
        for (std::size_t i = 0; i < x_.size(); ++i)  // 1/norm: the error beside the others as they are
            largest =
                std::max(largest, std::abs(next[i] - x_[i]) * A.col(static_cast<Eigen::Index>(i)).norm());
        return largest;
    }

    const Law& law_;
    const LawData& data_;
    std::vector<std::size_t> used_;
    std::vector<Free> free_;
    LawSetting base_;
    double first_s_ = NAN, drag_ = 0, tolerance_ = rough_tolerance;
    bool harmonics_ = false, ended_ = true;
    std::vector<double> x_;
    std::vector<LawCycle> at_;
};

// At most `most` points, evenly through the list.
std::vector<std::size_t> spread(std::size_t points, std::size_t most) {
    std::vector<std::size_t> out;
    const std::size_t n = std::min(points, most);
    for (std::size_t i = 0; i < n; ++i) out.push_back(i * points / n);
    return out;
}

bool all_have(std::span<const Point> points, double Point::*member) {
    return std::ranges::all_of(points, [&](const Point& p) { return std::isfinite(p.*member); });
}

std::string not_measured(const Law& law, const LawData& data) {
    if (data.coulomb->points.empty()) return data.coulomb->mu.note;
    if (law.needs == Law::Needs::tilt &&
        !(data.free_tilt && shows_tilt(data.points) && std::isfinite(data.tilt.sigma)))
        return "needs mirror partners and the tilt by gravity";
    if (law.needs == Law::Needs::time && !all_have(data.points, &Point::time_s))
        return "needs the times of all points";
    if (law.needs == Law::Needs::place && !all_have(data.points, &Point::place))
        return "needs the places of all points";
    return {};
}

}  // namespace

LawFit fit_law(const Law& law, const LawData& data) {
    LawFit none{.law = &law, .reason = not_measured(law, data)};
    if (!none.known()) return none;
    std::vector<std::size_t> all(data.points.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    try {
        LawSearch search{law, data, all};
        for (std::size_t i = 0; i < law.parameters.size(); ++i) {
            const auto& starts = law.parameters[i].starts;
            if (std::isnan(starts[1])) continue;
            double best = HUGE_VAL;
            for (const double value : starts) {
                if (std::isnan(value)) break;
                LawSearch few{law, data, spread(all.size(), start_points)};
                few.start(i, value);
                try {
                    const double chi2 = few.search(start_steps);
                    if (chi2 < best) best = chi2, search.start(few);
                } catch (const InputError&) {
                    continue;  // no settled motion about this start
                }
            }
        }
        search.search(most_steps);
        return search.finished();
    } catch (const InputError& error) {
        none.reason = error.what();
        return none;
    }
}

}  // namespace shaker::law
