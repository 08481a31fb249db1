#include "daemon/recording/tables/identification_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/recording/small_recording.hpp"

namespace shaker::recording {

using namespace test;
namespace {

using test::SessionFolder;

control::IdentifiedLevel level(double peak_V, double gain) {
    control::IdentifiedLevel l{.peak_V = peak_V, .peak_mps2 = 60 * gain * peak_V};
    for (std::size_t i = 0; i < 8; ++i) {
        l.h[i] = std::polar(gain * (60.0 + static_cast<double>(i)), 1 - 0.2 * static_cast<double>(i));
        l.sd[i] = 0.01 * static_cast<double>(i + 1);
        l.coherence[i] = 0.99;
        l.floor[i] = 0.002;
    }
    l.h[7] = 0;  // an antiresonance with unknown phase
    return l;
}

recorded::RecordingHeader header() {
    recorded::RecordingHeader h = test::small_header();
    h.groups = identification_places();
    return h;
}

class IdentificationRecordTest : public ::testing::Test {
protected:
    IdentificationRecordTest() {
        found_.harmonics = 8;
        found_.frequency = 25;
        found_.levels = {level(0.02, 1), level(0.06, 0.9)};
        found_.turn = 3;
        found_.gain = 0.95;
        found_.axis = {0.6, 0, -0.8};
        found_.across[2] = calibration::transverse(1, {std::complex<double>{0, 0.03}, 0}, found_.axis, 1e-4);
        recorded::RecordingWriter writer{file_, header()};
        write_identification(writer, found_);
        writer.close();
    }
    [[nodiscard]] recorded::Column column(const std::string& table, const std::string& name) const {
        for (recorded::Column& c : recorded::RecordingReader{file_}.table("identification/" + table))
            if (c.name == name) return c;
        ADD_FAILURE() << table << " has no column " << name;
        return {};
    }
    SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "id.nxs";
    control::IdentifiedResponse found_;
};

TEST_F(IdentificationRecordTest, ResponseIsOfHighestLevelInSi) {
    const recorded::Column f = column("response", "frequency"), m = column("response", "magnitude"),
                           p = column("response", "phase"), e = column("response", "phase_errors");
    EXPECT_EQ(f.units, "Hz");
    EXPECT_EQ(m.units, "m/s^2/V");
    EXPECT_EQ(p.units, "rad");
    ASSERT_EQ(m.values.size(), 8U);
    for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_EQ(f.values[i], 25.0 * static_cast<double>(i + 1));
        EXPECT_EQ(m.values[i], std::abs(found_.levels[1].h[i]));
        EXPECT_EQ(p.values[i], std::arg(found_.levels[1].h[i]));
        EXPECT_EQ(e.values[i], found_.levels[1].sd[i] / m.values[i]);
    }
    EXPECT_NEAR(e.values[7], two_pi / std::sqrt(12.0), 1e-12);
    EXPECT_EQ(column("response", "noise_floor").units, "m/s^2");
    EXPECT_EQ(column("response", "coherence").values, std::vector<double>(8, 0.99));
}

TEST_F(IdentificationRecordTest, HasEveryLevelAndCompression) {
    EXPECT_EQ(column("level_1", "magnitude").values[0], 60);
    EXPECT_NEAR(column("level_2", "magnitude").values[0], 54, 1e-12);
    EXPECT_NEAR(column("response", "gain_change").values[3], 0.9, 1e-12);
    EXPECT_NEAR(column("response", "phase_change").values[3], 0, 1e-12);
    const recorded::RecordingReader reader{file_};
    EXPECT_EQ(reader.scalar("identification/level_2_peak_drive"), 0.06);
    EXPECT_EQ(reader.scalar("identification/level_1_peak_acceleration"), 1.2);
    EXPECT_TRUE(reader.numbers("identification/level_3/magnitude").empty());
}

TEST_F(IdentificationRecordTest, HasPolarityAxisAndTransverseMotion) {
    const recorded::RecordingReader reader{file_};
    EXPECT_EQ(reader.scalar("identification/polarity"), -1);
    EXPECT_EQ(reader.scalar("identification/turn"), 3);
    EXPECT_EQ(reader.scalar("identification/shaker_axis_z"), -0.8);
    EXPECT_NEAR(column("transverse", "share").values[2], 0.03, 1e-12);
    EXPECT_NEAR(column("transverse", "quadrature").values[2], 0.03, 1e-12);
    EXPECT_NEAR(column("transverse", "share_errors").values[2], 1e-4, 1e-6);
}

TEST_F(IdentificationRecordTest, UnmeasuredQuantitiesAreAbsent) {
    {
        recorded::RecordingWriter writer{folder_ / "none.nxs", header()};
        write_identification(writer, {});
        writer.close();
    }
    const recorded::RecordingReader reader{folder_ / "none.nxs"};
    EXPECT_TRUE(std::isnan(reader.scalar("identification/gain")));
    EXPECT_TRUE(reader.numbers("identification/response/magnitude").empty());
}

}  // namespace
}  // namespace shaker::recording
