#include "drivers/sampled_drive.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

std::vector<double> period_of(const Drive& drive, std::size_t samples, double from) {
    std::vector<double> a;
    for (std::size_t i = 0; i < samples; ++i)
        a.push_back(value_at(harmonics(drive),
                             from + two_pi * static_cast<double>(i) / static_cast<double>(samples)));
    return a;
}

Drive with_overtones() {
    Drive drive{25, 12, 0.4, 0.7, {}};
    drive.overtones[0] = std::polar(0.2, -1.0);
    drive.overtones[5] = std::polar(0.05, 2.0);
    return drive;
}

TEST(SampledDriveTest, RecoversDriveFromAnyStartOfPeriod) {
    const Drive drive = with_overtones();
    for (const double from : {0.0, 0.3, 2.0, 5.9})
        for (const std::size_t samples : {std::size_t{18}, std::size_t{19}, std::size_t{400}}) {
            const Drive got = drive_of_period(period_of(drive, samples, from), 25);
            EXPECT_EQ(got.frequency, 25);
            EXPECT_NEAR(got.gamma, 12, 1e-12);
            EXPECT_NEAR(got.rho, 0.4, 1e-13);
            EXPECT_NEAR(std::remainder(got.phi - 0.7, two_pi), 0, 1e-12);
            for (std::size_t i = 0; i < drive.overtones.size(); ++i)
                EXPECT_NEAR(std::abs(got.overtones[i] - drive.overtones[i]), 0, 1e-12)
                    << from << ' ' << i + 3;
        }
}

TEST(SampledDriveTest, IgnoresTheMean) {
    std::vector<double> a = period_of(with_overtones(), 64, 1);
    for (double& x : a) x += 3;
    EXPECT_NEAR(drive_of_period(a, 25).gamma, 12, 1e-12);
}

TEST(SampledDriveTest, RefusesUnplayableHarmonicsWithShare) {
    std::vector<double> square(200);
    for (std::size_t i = 0; i < square.size(); ++i) square[i] = i < 100 ? 1 : -1;
    const auto why = [](const std::vector<double>& a) -> std::string {
        try {
            static_cast<void>(drive_of_period(a, 20));
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    // Harmonics 1, 3, 5 and 7 of a square wave hold 8/pi^2 (1 + 1/9 + 1/25 + 1/49) of its power.
    EXPECT_NE(why(square).find("22.39 %"), std::string::npos) << why(square);
    EXPECT_NE(why({1, 2, 3}).find("3 samples"), std::string::npos);
    EXPECT_NE(why(std::vector<double>(64, NAN)).find("not finite"), std::string::npos);
    EXPECT_NE(why(std::vector<double>(64, 1.0)).find("no harmonics 1 and 2"), std::string::npos)
        << why(std::vector<double>(64, 1.0));
}

TEST(DriveTest, OvertonesAreSharesOfGamma) {
    const Harmonics<Acceleration> h = harmonics(with_overtones());
    EXPECT_NEAR(std::abs(h.at(3)), 2.4, 1e-15);
    EXPECT_NEAR(std::arg(h.at(8)), 2.0, 1e-15);
    EXPECT_EQ(h.order(), 8);
    EXPECT_FALSE(with_overtones().biharmonic());
    EXPECT_TRUE(Drive{}.biharmonic());
}

}  // namespace
}  // namespace shaker
