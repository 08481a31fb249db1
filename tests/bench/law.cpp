// Fits of the law of friction: cost beside error for each estimator.
//   --campaign FOLDER (12 synthetic points with the noise of the bench)   --mu MU (0.113): the truth
#include <cstdio>
#include <cstdlib>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/law/findings.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"
#include "tests/support/law/synthetic_points.hpp"

namespace shaker {
namespace {

std::vector<law::Point> points_for(const std::string& folder, double mu) {
    if (!folder.empty())
        return campaign::law_points(
            campaign::read_points(std::filesystem::path{folder} / campaign::table_name));
    std::vector<law::Point> points = test::exact_points({.mu = mu, .push = 0.06 / 0.557});
    std::mt19937_64 random{1};
    test::add_noise(points, random);
    return points;
}

bench::Row row_of(const law::Fit& fit, double truth, double cost_ns) {
    return {{"estimator", fit.name},
            {"points", static_cast<double>(fit.points), "", 6},
            {"cost", 1e-6 * cost_ns, "ms"},
            {"error", 100 * (fit.value / truth - 1), "%"},
            {"stated", 100 * fit.error / truth, "%"},
            {"chi^2 per degree of freedom", fit.chi2 / fit.freedom}};
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) try {
    using namespace shaker;
    const double mu = std::atof(bench::option(argc, argv, "--mu", "0.113").c_str());
    const std::vector<law::Point> points = points_for(bench::option(argc, argv, "--campaign", ""), mu);
    bench::Table table;
    law::CoulombFit fit;
    const double coulomb_ns = bench::median_cost_ns(3, [&] { fit = law::fit_coulomb(points); });
    table.add(row_of(fit.mu, mu, coulomb_ns));
    law::CoulombOptions near;
    near.start_mu = mu;
    law::CoulombFit again;
    const double near_ns = bench::median_cost_ns(3, [&] { again = law::fit_coulomb(points, near); });
    again.mu.name = "mu_ac, start known";
    table.add(row_of(again.mu, mu, near_ns));
    law::SlopeFit slopes;
    const double slopes_ns = bench::median_cost_ns(5, [&] { slopes = law::fit_slopes(points); });
    table.add(row_of(slopes.mu, mu, slopes_ns));
    law::Fit no_stick;
    const double nulls_ns = bench::median_cost_ns(
        5, [&] { no_stick = law::fit_no_stick(law::null_phases(points), fit.mu.value); });
    table.add(row_of(no_stick, mu, nulls_ns));
    const double asked_ns = bench::median_cost_ns(3, [&] {
        for (std::size_t i = 0; i < points.size() && fit.known(); ++i)
            (void)law::on_asked_drive(points[i], fit.points[i], fit);
    });
    table.add({{"estimator", "v_D on the asked drive"},
               {"points", static_cast<double>(points.size()), "", 6},
               {"cost", 1e-6 * asked_ns, "ms"}});
    table.print(argc, argv);
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
