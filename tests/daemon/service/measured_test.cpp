// A recording by the daemon has every finished measurement of its run and no interrupted one.
#include <gtest/gtest.h>

#include <numbers>

#include "daemon/commands/replay.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using recording::FinishedMeasurement;
using test::Answers;
using test::in;
using test::orders;
using test::slow;

// Cameras that stamp by their own clocks: the time of a frame follows from the stamps of the whole run.
constexpr const char* own_clocks =
    "[top]\npositions = 1\nframe_rate_hz = 200\nown_clock = 1\nclock_ppm = 30\n"
    "[side]\npositions = 1\nframe_rate_hz = 200\nown_clock = 1\nclock_ppm = -20\n";
constexpr int periods = 10;

run::RunOptions quick() {
    run::RunOptions run;
    run.pictures = recorded::KeptPictures::off;
    run.plan.periods = periods;
    return run;
}

auto measured(std::size_t n) {
    return [n](const BenchState& s) { return s.points.size() >= n; };
}

// Two measurements, then a third one of another set-point; each set-point's last one is interrupted.
test::OnCallResult series(const std::filesystem::path& folder, const Drive& other, const char* scene = slow) {
    Answers answers;
    auto r = test::play_on_call(
        scene, quick(), folder,
        {{in(run::RunState::idle), orders(Record{true, "series", recorded::KeptPictures::off}, answers)},
         {in(run::RunState::idle), orders(Begin{periods}, answers)},
         {measured(2), orders(SetDrive{other}, answers)},
         {measured(3), orders(End{}, answers)},
         {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(4, ""));
    return r;
}

Drive other_drive() {
    Drive other;
    other.gamma = 8;
    other.phi = 1.2;
    other.overtones[0] = {0.05, 0.02};
    return other;
}

class MeasuredSeriesTest : public testing::Test {
protected:
    std::filesystem::path folder_ = test::fresh_folder();
    std::filesystem::path file_ = folder_ / "series.nxs";
};

TEST_F(MeasuredSeriesTest, EveryFinishedMeasurementIsKept) {
    const Drive other = other_drive();
    const auto r = series(folder_, other);
    const recorded::RecordingReader file{file_};
    const std::vector<FinishedMeasurement> all = recording::read_finished(file);
    ASSERT_EQ(all.size(), 3U);
    ASSERT_EQ(r.last.points.size(), 3U);
    const auto bytes = static_cast<double>(std::filesystem::file_size(file_));
    EXPECT_GT(r.last.recording.rate.bytes_per_s, bytes / r.last.now_s);
    EXPECT_LT(r.last.recording.rate.bytes_per_s, bytes / (r.last.parts[2].to_s - r.last.parts[0].from_s));
    EXPECT_GE(file.numbers("measurements/from").size(), 4U) << "the interrupted one was begun, too";
    const std::vector<double> v_D = file.numbers("measured/results/v_D"),
                              periods_of = file.numbers("measured/periods/measurement");
    ASSERT_EQ(v_D.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(all[i].number, static_cast<int>(i) + 1);
        EXPECT_EQ(all[i].asked.gamma, i < 2 ? paper_g : 8);
        EXPECT_EQ(all[i].asked.phi, i < 2 ? 0 : 1.2);
        EXPECT_EQ(all[i].asked.rho, 0.5);
        EXPECT_EQ(all[i].asked.overtones, i < 2 ? Drive{}.overtones : other.overtones);
        EXPECT_EQ(all[i].part, r.last.parts[i]);
        EXPECT_NEAR((all[i].part.to_s - all[i].part.from_s) * all[i].asked.frequency, periods, 1e-6);
        EXPECT_TRUE(all[i].time.starts_with("1970-01-01T00:00:")) << all[i].time;
        // At the end of the run the clocks are known better than at the end of the measurement.
        EXPECT_NEAR(v_D[i], r.last.points[i].v_D.value, r.last.points[i].v_D.sigma);
        EXPECT_GE(std::ranges::count(periods_of, all[i].number), periods - 1);
    }
    EXPECT_EQ(file.scalar("results/v_D"), v_D[2]);
    EXPECT_EQ(file.scalar("process/reduced_from"), all[2].part.from_s);
    EXPECT_TRUE(commands::replay({.file = file_}));
}

// The drive moved the base before the recording began: the recording has no stamps of that time.
TEST_F(MeasuredSeriesTest, CamerasWithOwnClocksGiveTheSameResults) {
    std::filesystem::create_directory(folder_ / "exact");
    const auto exact = series(folder_ / "exact", other_drive());
    const auto r = series(folder_, other_drive(), own_clocks);
    const std::vector<FinishedMeasurement> all = recording::read_finished(recorded::RecordingReader{file_});
    ASSERT_EQ(all.size(), 3U);
    ASSERT_EQ(r.last.points.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        const calibration::Estimate v_D = r.last.points[i].v_D, expected = exact.last.points[i].v_D;
        EXPECT_NEAR(v_D.value, expected.value, std::hypot(v_D.sigma, expected.sigma)) << i;
    }
    const recorded::RecordingReader file{file_};
    EXPECT_TRUE(file.frames("top").back().stamp) << "the camera's own clock";
    EXPECT_TRUE(commands::replay({.file = file_}));
}

TEST_F(MeasuredSeriesTest, ReplayFindsAChangeInAnyMeasurement) {
    series(folder_, other_drive());
    {
        const h5::Handle file{H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
        const h5::Handle set{H5Dopen2(file.get(), "entry/measured/results/v_D", H5P_DEFAULT), "v_D"};
        std::array<double, 3> v_D{};
        h5::check(H5Dread(set.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, v_D.data()), "v_D");
        v_D[1] = std::nextafter(v_D[1], 1.0);
        h5::check(H5Dwrite(set.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, v_D.data()), "v_D");
    }
    const test::Outcome o = test::shakerd("replay series.nxs", folder_);
    EXPECT_EQ(o.status, 4) << o.err;
    EXPECT_NE(o.err.find("measured/results/v_D row 1 (measurement 2)"), std::string::npos) << o.err;
    EXPECT_NE(o.out.find("3 measurements:"), std::string::npos) << o.out;
    EXPECT_NE(o.out.find("NOT identical"), std::string::npos) << o.out;
}

TEST_F(MeasuredSeriesTest, RecoveryComputesEveryMeasurementAgain) {
    series(folder_, other_drive());
    std::filesystem::create_directory(folder_ / "crash");
    std::filesystem::copy_file(file_, folder_ / "crash" / "series.nxs.part");
    const test::Outcome o = test::shakerd("recover crash/series.nxs.part", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    const recorded::RecordingReader before{file_}, after{folder_ / "crash" / "series.nxs"};
    EXPECT_EQ(recording::read_finished(after).size(), 3U);
    for (const char* column : {"measured/results/v_D", "measured/harmonics/phase", "measured/cycle/v",
                               "measured/periods/D_errors"})
        EXPECT_EQ(testing::PrintToString(after.numbers(column)),
                  testing::PrintToString(before.numbers(column)))
            << column;
    EXPECT_EQ(after.texts("measured/time"), before.texts("measured/time"));
    EXPECT_TRUE(commands::replay({.file = folder_ / "crash" / "series.nxs"}));
}

TEST_F(MeasuredSeriesTest, ExportHasTheirTables) {
    series(folder_, other_drive());
    const test::Outcome o = test::shakerd("export --what measured -o out series.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    for (const char* name : {"measured", "measured-results", "measured-harmonics", "measured-transverse",
                             "measured-periods", "measured-cycle", "measured-stick", "measured-notes"})
        EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / (std::string{name} + ".csv"))) << name;
    std::ifstream in{folder_ / "out" / "measured-results.csv"};
    std::string line;
    std::getline(in, line);
    EXPECT_TRUE(line.starts_with("measurement [1],v_D [m/s],v_D_errors [m/s]")) << line;
    int rows = 0;
    while (std::getline(in, line)) ++rows;
    EXPECT_EQ(rows, 3);
}

TEST_F(MeasuredSeriesTest, TripKeepsFinishedMeasurements) {
    Answers answers;
    const auto r = test::play_on_call(
        slow, quick(), folder_,
        {{in(run::RunState::idle), orders(Record{true, "series", recorded::KeptPictures::off}, answers)},
         {in(run::RunState::idle), orders(Begin{periods}, answers)},
         {measured(2), [](BenchPort& d) { d.abort("a test"); }},
         {[](const BenchState& s) { return s.may_clear; }, [](BenchPort&) {}}});
    const recorded::RecordingReader file{file_};
    EXPECT_EQ(recording::read_trips(file).size(), 1U);
    const std::vector<FinishedMeasurement> all = recording::read_finished(file);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(file.numbers("measured/results/measurement"), (std::vector<double>{1, 2}));
    EXPECT_EQ(file.scalar("process/reduced_to"), all[1].part.to_s);
    EXPECT_NEAR(file.scalar("results/v_D"), r.last.points[1].v_D.value, r.last.points[1].v_D.sigma);
    EXPECT_TRUE(commands::replay({.file = file_}));
}

// The measurements of a viscous walker contradict Coulomb's law: its mu predicts walks with an error of 20 %,
// and gives way to the operator's.
TEST(GivenMuTest, IsUsedWhereTheMeasurementsContradictTheFittedOne) {
    Answers answers;
    std::vector<test::Move> moves{{in(run::RunState::idle), orders(Begin{periods}, answers)}};
    for (std::size_t n = 1; n < 6; ++n) {
        Drive next;
        next.gamma = (0.35 + 0.05 * static_cast<double>(n)) * paper_g;
        next.phi = n % 2 == 0 ? 0 : std::numbers::pi;
        moves.push_back({measured(n), orders(SetDrive{next}, answers)});
    }
    calibration::Estimate fitted;
    moves.push_back({[&](const BenchState& s) {
                         fitted = s.mu;
                         return s.points.size() >= 6 && s.fitted_mu.refused;
                     },
                     orders(GiveMu{{0.113, 0.002}}, answers)});
    moves.push_back({measured(8), orders(End{}, answers)});
    const auto r = test::play_on_call(std::string{slow} + "[walker]\nviscous_per_s = 5\n", quick(),
                                      test::fresh_folder(), std::move(moves));
    EXPECT_EQ(answers, Answers(8, ""));
    EXPECT_TRUE(r.last.fitted_mu.refused) << r.last.fitted_mu.note;
    EXPECT_GT(fitted.sigma, 0.19 * fitted.value);
    EXPECT_EQ(r.last.mu.value, 0.113);
}

}  // namespace
}  // namespace shaker::service
