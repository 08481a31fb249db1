#include "drivers/footage/csv_accelerometer.hpp"

#include <cmath>

#include "drivers/quantity.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::footage {

using namespace test;
namespace {

using test::expect_in;
using test::no_wait;
using test::refusal;
using test::SessionFolder;

struct Row {
    double t;
    double ax = 0, ay = 0, az = 0;
};

CsvAccelerometerFile described(const std::filesystem::path& file) {
    return {.file = file,
            .time = "t_s",
            .axes = {"ax", "ay", "az"},
            .clock_uncertainty_s = 0.03,
            .shaker_axis = {0, 1, 0}};
}

std::string table_of(const std::vector<Row>& rows) {
    std::string text = "t_s,ax,ay,az\n";
    for (const Row& r : rows)
        text += to_text(r.t) + "," + to_text(r.ax) + "," + to_text(r.ay) + "," + to_text(r.az) + "\n";
    return text;
}

std::unique_ptr<Accelerometer> open(const SessionFolder& folder, const std::vector<Row>& rows) {
    return open_csv_accelerometer(described(folder.write("accel.csv", table_of(rows)))).accelerometer;
}

std::vector<AccelBlock> all_blocks(Accelerometer& accelerometer) {
    std::vector<AccelBlock> blocks;
    for (AccelBlock block; accelerometer.read(block, no_wait);) blocks.push_back(block);
    return blocks;
}

TEST(CsvAccelerometerTest, EveryDigitOfTheTextSurvives) {
    const SessionFolder folder;
    std::vector<Row> rows(150);
    for (int i = 0; i < 150; ++i)
        rows[static_cast<std::size_t>(i)] = {0.00025 * i, -11.765631 + 0.000013 * i, 0.405260 - i,
                                             9.816808 + 0.5 * (i % 7)};
    const auto device = open(folder, rows);
    const AccelerometerInfo info = device->info();
    EXPECT_NEAR(info.rate_hz, 4000, 1e-6);
    EXPECT_NEAR(info.first_sample_s, 0, 1e-12);
    EXPECT_EQ(info.clock_uncertainty_s, 0.03);
    EXPECT_EQ(info.shaker_axis, (std::array<double, 3>{0, 1, 0}));
    // The largest, 148.59, is 1.5e9 counts; one more digit is too many.
    EXPECT_EQ(info.mps2_per_count[0], 1e-7);
    const auto blocks = all_blocks(*device);
    ASSERT_EQ(blocks.size(), 3U);
    EXPECT_TRUE(device->ended());
    std::size_t i = 0;
    for (const AccelBlock& block : blocks) {
        EXPECT_EQ(block.first.n, static_cast<std::int64_t>(i));
        EXPECT_EQ(block.quality, Quality::good);
        for (int k = 0; k < block.size; ++k, ++i) {
            const auto& counts = block.counts[static_cast<std::size_t>(k)];
            EXPECT_NEAR(counts[0] * info.mps2_per_count[0], rows[i].ax, 0.51e-7);  // half a count
            EXPECT_NEAR(counts[1] * info.mps2_per_count[1], rows[i].ay, 0.51e-7);
            EXPECT_NEAR(counts[2] * info.mps2_per_count[2], rows[i].az, 0.51e-7);
        }
    }
    EXPECT_EQ(i, rows.size());
    EXPECT_EQ(blocks[0].size, 64);
    EXPECT_EQ(blocks[2].size, 150 - 128);
    EXPECT_EQ(blocks[2].arrived.time_since_epoch().count(), std::llround(149 * 0.00025e9));
}

TEST(CsvAccelerometerTest, OneColumnIsOneAxis) {
    const SessionFolder folder;
    CsvAccelerometerFile file = described(folder.write("accel.csv", "t_s,ax,ay,az\n0,1,2,3\n0.1,-4,5,6\n"));
    file.axes = {"ax"};
    file.gravity = false;
    file.shaker_axis = {1, 0, 0};
    const auto device = open_csv_accelerometer(file).accelerometer;
    EXPECT_EQ(device->info().axes, 1);
    EXPECT_FALSE(device->info().gravity);
    EXPECT_EQ(device->info().mps2_per_count[1], 0);
    const AccelBlock block = all_blocks(*device).at(0);
    EXPECT_NEAR(device->info().acceleration(block.counts[1])[0], -4, 1e-9);
    EXPECT_EQ(block.counts[1][1], 0);
}

TEST(CsvAccelerometerTest, MissingSamplesSkipTicksAndMarkNextBlock) {
    const SessionFolder folder;
    std::vector<Row> rows;
    for (int i = 0; i < 100; ++i)
        if (i < 40 || i > 44) rows.push_back({5 + 0.001 * i, 1.0 * i});
    const auto device = open(folder, rows);
    const auto blocks = all_blocks(*device);
    ASSERT_EQ(blocks.size(), 2U);
    EXPECT_EQ(blocks[0].size, 40);
    EXPECT_EQ(blocks[0].quality, Quality::good);
    EXPECT_EQ(blocks[1].first.n, 45);
    EXPECT_EQ(blocks[1].size, 55);
    EXPECT_EQ(blocks[1].quality, Quality::gap);
    EXPECT_NEAR(device->info().first_sample_s, 5, 1e-9);
}

TEST(CsvAccelerometerTest, RoundedStampsDoNotMiscountALongGap) {
    // At 3 kHz in whole microseconds most steps read 333 us: 1e-3 too short, 40 samples wrong over this gap.
    const SessionFolder folder;
    std::vector<Row> rows(1000);
    for (int i = 0; i < 1000; ++i)
        rows[static_cast<std::size_t>(i)].t = std::round(1e6 * (i < 500 ? i : i + 40000) / 3000.0) * 1e-6;
    const auto device = open(folder, rows);
    EXPECT_NEAR(device->info().rate_hz, 3000, 1e-3);
    std::int64_t first_after = 0;
    for (const AccelBlock& block : all_blocks(*device))
        if (block.quality == Quality::gap) first_after = block.first.n;
    EXPECT_EQ(first_after, 40500);
}

TEST(CsvAccelerometerTest, CorrectsSmallJitterAndRefusesLargeJitter) {
    const SessionFolder folder;
    std::vector<Row> rows(400);
    for (int i = 0; i < 400; ++i)
        rows[static_cast<std::size_t>(i)].t = 0.001 * i + (i % 2 == 0 ? 0.1e-3 : -0.1e-3);
    EXPECT_NEAR(open(folder, rows)->info().rate_hz, 1000, 0.01);
    rows[200].t += 0.25e-3;
    expect_in(refusal([&] { open(folder, rows); }), {"accel.csv:202: ", "\"t_s\"", "20 %"});
}

TEST(CsvAccelerometerTest, BadTablesAreRefusedByFileAndLine) {
    const SessionFolder folder;
    const auto attempt = [&](const std::string& text) {
        return refusal([&] { open_csv_accelerometer(described(folder.write("accel.csv", text))); });
    };
    expect_in(attempt("t_s,ax,ay\n0,1,2\n"), {"accel.csv:1: ", "column \"az\" is missing"});
    expect_in(attempt("t_s,ax,ay,az\n0,1,2,3\n0.1,1,nan,3\n"), {"accel.csv:3: ", "column \"ay\"", "\"nan\""});
    expect_in(attempt("t_s,ax,ay,az\n0,1,2,3\n0.1,one,2,3\n"), {"accel.csv:3: ", "column \"ax\"", "\"one\""});
    expect_in(attempt("t_s,ax,ay,az\n0,1,2,3\n0.1,1,2,3\n0.05,1,2,3\n"), {"accel.csv:4: ", "must increase"});
    expect_in(attempt("t_s,ax,ay,az\n0,1,2,3\n"), {"accel.csv: ", "at least two samples"});
    expect_in(attempt("t_s,ax,ay,az\n0,1,2,3\n1,1,2,1e7\n"), {"accel.csv:3: ", "\"az\"", "at most 1e6"});
    expect_in(attempt("t_s,ax,ay,az\n"), {"accel.csv: has a header but no rows"});
    expect_in(attempt(""), {"accel.csv: is empty"});
}

TEST(CsvAccelerometerTest, StoppingEndsIt) {
    const SessionFolder folder;
    const auto device = open(folder, {{0}, {1}, {2}});
    device->stop();
    AccelBlock block;
    EXPECT_TRUE(device->ended());
    EXPECT_FALSE(device->read(block, no_wait));
}

}  // namespace
}  // namespace shaker::footage
