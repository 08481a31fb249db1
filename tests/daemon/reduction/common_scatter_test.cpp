#include "daemon/reduction/spread/common_scatter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "daemon/reduction/spread/drift_spread.hpp"
#include "tests/support/nightly.hpp"

namespace shaker::reduction {
namespace {

struct CommonRow {
    const char* name;
    double jitter, memory;
};

constexpr double error_m = 0.2e-6, response_m = 240e-6;  // as at 1 g

/// A record of a walker with v_D = 0. One period is only in part in the means, as that before the drive's
/// phase 0.
struct Walked {
    WalkerRecord record;
    double slope_m = 0;  // of the line through all periods
};

Walked walked(const CommonRow& row, int periods, double response, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    Walked out{{{}, periods, error_m, response_m}};
    const double jitter = row.jitter * response;
    double u = jitter * normal(random), x = 0, moment = 0;
    for (int k = 0; k < periods; ++k) {
        const double y = x + u / 2 + error_m * normal(random);
        moment += (k - (periods - 1) / 2.0) * y;
        if (k > 0) out.record.means.push_back({k, y, 100});
        x += u;
        u = row.memory * u + std::sqrt(1 - row.memory * row.memory) * jitter * normal(random);
    }
    out.slope_m = 12 * moment / (periods * (periods * periods - 1.0));
    return out;
}

struct Covered {
    double own = 0, common = 0, z_rms = 0;
};

/// Campaigns of `count` records; the response of each differs from the stated one.
Covered covered(const CommonRow& row, int periods, int count, int campaigns, unsigned seed) {
    std::mt19937_64 random{seed};
    std::normal_distribution<double> normal;
    Covered out;
    const double all = count * campaigns;
    for (int c = 0; c < campaigns; ++c) {
        std::vector<Walked> some;
        std::vector<WalkerRecord> records;
        for (int i = 0; i < count; ++i) {
            some.push_back(walked(row, periods, response_m * std::exp(0.2 * normal(random)), random));
            records.push_back(some.back().record);
        }
        const auto sigmas = common_sigmas(records);
        for (std::size_t i = 0; i < some.size(); ++i) {
            const double error = std::abs(some[i].slope_m);
            const ScatterPrior alone{.white_m = error_m, .jitter_m = usual_jitter * response_m};
            out.own += error < 2 * drift_spread(records[i].means, alone).sigma_m ? 1 / all : 0;
            out.common += error < 2 * sigmas[i] ? 1 / all : 0;
            out.z_rms += std::pow(error / sigmas[i], 2) / all;
        }
    }
    out.z_rms = std::sqrt(out.z_rms);
    std::printf("%-24s %3d records of %3d periods: covered alone %.3f, with the others %.3f, z rms %.2f\n",
                row.name, count, periods, out.own, out.common, out.z_rms);
    return out;
}

class CommonScatterTest : public ::testing::TestWithParam<CommonRow> {};

// 24 points, as in the plan mu.toml. With 5 or 10 periods errors may be too large: what the periods do not
// show is in the prior.
TEST_P(CommonScatterTest, ErrorsOfManyShortRecordsCoverTheTruth) {
    for (const int periods : {5, 10, 20, 40}) {
        if (periods == 40 && !test::nightly()) continue;
        const Covered c = covered(GetParam(), periods, 24, test::nightly() ? 80 : 10, 7);
        EXPECT_GE(c.common, periods > 5 ? 0.92 : 0.9) << periods;  // ten walkers
        EXPECT_LE(c.common, periods > 10 ? 0.99 : 1) << periods;
    }
}

INSTANTIATE_TEST_SUITE_P(Walkers, CommonScatterTest,
                         ::testing::Values(CommonRow{"steady", 0, 0}, CommonRow{"jitter 0.1 %", 1e-3, 0},
                                           CommonRow{"jitter 1 %", 0.01, 0},
                                           CommonRow{"jitter 2 %, memory 0.5", 0.02, 0.5},
                                           CommonRow{"jitter 3 %, memory 0.9", 0.03, 0.9}));

TEST(CommonScatterTest, FewRecordsDoNotCoverLessThanOneAlone) {
    for (const int count : {2, 4})
        for (const CommonRow& row :
             {CommonRow{"jitter 1 %", 0.01, 0}, CommonRow{"jitter 2 %, memory 0.5", 0.02, 0.5}}) {
            const Covered c = covered(row, 10, count, 400 / count, 11);
            EXPECT_GE(c.common, c.own - 0.02);
        }
}

}  // namespace
}  // namespace shaker::reduction
