// Exported files have the content of the recording, and no file is overwritten.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/steps.hpp"
#include "daemon/export/tables.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/played_drive.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/devices/queued_dac.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::exporting {
namespace {

using test::fresh_folder;
using test::Outcome;
using test::shakerd;

constexpr std::size_t block = 240;

/// A minute with random changes, stops and underruns of the drive.
struct EventfulDrive {
    test::QueuedDac dac{2400, 480};
    std::vector<DriveChange> changes;
    std::vector<PlayTime> played;
    int stops = 0, silences = 0;

    explicit EventfulDrive(unsigned seed) {
        std::mt19937 random{seed};
        const auto chance = [&](double p) { return std::uniform_real_distribution{0.0, 1.0}(random) < p; };
        const auto between = [&](double a, double b) { return std::uniform_real_distribution{a, b}(random); };
        acquisition::Channels channels{0};
        acquisition::DriveOutput output{dac.info(), 23.7, 1000, block};
        for (int k = 0; k < 12000; ++k) {
            if (chance(0.02)) {
                DriveCommand c;
                for (int q = 1; q <= 4; ++q) c.volts.at(q) = std::polar(between(0, 0.2), between(0, 6));
                c.frequency = chance(0.3) ? between(5, 90) : 23.7;
                c.ramp_periods = 1 + static_cast<int>(between(0, 4));
                c.sequence = static_cast<std::uint64_t>(k);
                channels.drive.post(c);
            }
            if (chance(0.002))
                static_cast<void>(channels.ordered.push(
                    {.cause = safety::Cause::operator_stop, .stop = safety::StopKind::hard}));
            if (chance(0.004))
                static_cast<void>(channels.ordered.push(
                    {.cause = safety::Cause::operator_stop, .stop = safety::StopKind::soft}));
            if (chance(0.01)) channels.clearance.post({output.newest.number, 0});
            if (chance(0.001)) dac.loses = 1 + static_cast<std::int64_t>(between(0, 5000));
            output_step(output, dac, channels);
            while (const auto change = channels.changes.pop()) {
                changes.push_back(*change);
                stops += change->stop > 0 ? 1 : 0;
                silences += change->stop == 0 && change->ramp == 0 ? 1 : 0;
            }
            while (const auto p = channels.played.pop()) played.push_back(*p);
            while (channels.trips.pop()) {
            }
        }
    }
};

std::vector<std::uint64_t> bits(std::span<const double> values) {
    std::vector<std::uint64_t> out;
    for (const double v : values) out.push_back(std::bit_cast<std::uint64_t>(v));
    return out;
}

TEST(ExportTest, RecomputedDriveIsBitIdentical) {
    for (const unsigned seed : {1U, 2U, 3U}) {
        const EventfulDrive run{seed};
        ASSERT_GT(run.changes.size(), 50U);
        ASSERT_GT(run.stops, 3);
        ASSERT_GT(run.silences, 3);
        ASSERT_GT(run.dac.taken_back, 1000);
        recorded::PlayedDrive again{run.dac.info(), 23.7, run.changes, run.played};
        std::vector<double> volts(run.dac.given.size());
        again.fill(std::span{volts}.first(12345));
        again.fill(std::span{volts}.subspan(12345));
        EXPECT_EQ(bits(volts), bits(run.dac.given)) << seed;
    }
}

TEST(ExportTest, ImpossibleChangesAreRefused) {
    const EventfulDrive run{4};
    std::vector<double> volts(run.dac.given.size());
    ASSERT_NO_THROW((recorded::PlayedDrive{run.dac.info(), 23.7, run.changes, run.played}.fill(volts)));
    const auto refused = [&](auto&& bend) {
        std::vector<DriveChange> changes = run.changes;
        std::vector<PlayTime> played = run.played;
        bend(changes, played);
        EXPECT_THROW((recorded::PlayedDrive{run.dac.info(), 23.7, changes, played}.fill(volts)), InputError);
    };
    refused([](auto& changes, auto&) { changes[5].first.n += 1; });
    refused([](auto& changes, auto&) { changes[5].first.n = -1; });
    refused([](auto& changes, auto&) { changes[5].phase += 1; });
    refused([](auto& changes, auto&) { changes[5].step += 1; });
    refused([](auto& changes, auto&) { changes[5].ramp += 1; });
    refused([](auto& changes, auto&) { changes.erase(changes.begin() + 5); });
    refused([](auto& changes, auto&) { std::swap(changes[5], changes[6]); });
    refused([](auto&, auto& played) {
        for (PlayTime& p : played) p.lost = 0;
    });
    refused([](auto& changes, auto&) { changes[5].command.volts.at(1) = NAN; });
}

/// A short recorded run, and commands on its recording.
class ExportedRun : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        const Outcome o = shakerd("run --no-identify --periods 4 --frames off -o run.nxs", folder_);
        ASSERT_EQ(o.status, 0) << o.err;
    }
    [[nodiscard]] Outcome exported(const std::string& arguments) const {
        return shakerd("export run.nxs " + arguments, folder_);
    }
    void python(const std::string& name, const std::string& program) const {
        std::ofstream{folder_ / name} << program;
        const std::string command = "cd '" + folder_.string() + "' && /usr/bin/python3 " + name;
        EXPECT_EQ(std::system(command.c_str()), 0) << program;
    }
    std::filesystem::path folder_;
};

constexpr const char* compare = R"(
import h5py, numpy as np
e = h5py.File('run.nxs')['entry']
def same(a, b):
    a, b = np.asarray(a, float).ravel(), np.asarray(b, float).ravel()
    assert len(a) == len(b) and len(a) > 0 and np.array_equal(a, b, equal_nan=True), (a, b)
tracks = [f'tracks/{c}/{t}' for c in ('top', 'side') for t in ('walker', 'base')]
def check(column):
    for table in tracks + ['cycle', 'periods', 'harmonics', 'truth/top']:
        for name in e[table]: same(column(table, name, e[table][name].attrs['units'].decode()), e[table][name])
    for name in e['results']:
        if name != 'notes': same(column('results', name, e['results'][name].attrs['units'].decode()), e['results'][name])
    raw, r = e['raw/accelerometer'], e['results']
    for k, axis in enumerate('xyz'):
        counts = raw['counts'][:, k]
        same(column('accelerometer', 'counts_' + axis, 'count'), counts)
        a = raw.attrs
        same(column('accelerometer', 'a_' + axis, 'm/s^2'),
             (counts + a['offset_counts_' + axis]) * a['mps2_per_count_' + axis])
    t = np.asarray(column('accelerometer', 't', 's'), float).ravel()
    rate = raw.attrs['rate_hz']
    assert np.allclose(np.diff(t), 1 / rate, rtol=1e-3, atol=0), np.diff(t)
    same(column('frames/top', 'tick', '1'), e['raw/top/tick'])
)";

TEST_F(ExportedRun, CsvHoldsEveryNumberToTheLastDigit) {
    const Outcome o = exported("-o csv --json");
    ASSERT_EQ(o.status, 0) << o.err;
    const nlohmann::json said = nlohmann::json::parse(o.out);
    for (const auto& t : said["tables"])
        EXPECT_TRUE(std::filesystem::exists(folder_ / t["file"].get<std::string>())) << t;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "csv/drive.csv"));
    python("csv.check.py", std::string{compare} + R"(
import csv
def column(table, name, unit):
    with open('csv/' + table.replace('/', '-') + '.csv', newline='') as f: rows = list(csv.reader(f))
    k = rows[0].index(f'{name} [{unit}]')
    return [float(row[k]) for row in rows[1:]]
check(column)
rows = list(csv.reader(open('csv/events.csv', newline='')))
assert rows[0] == ['t [s]', 'state', 'text'], rows[0]
assert [r[1] for r in rows[1:]] == [s.decode() for s in e['events/state'][:]], rows
)");
}

TEST_F(ExportedRun, RefusalOverwritesAndLeavesNothing) {
    ASSERT_EQ(exported("-o once --what results,cycle").status, 0);
    std::ofstream{folder_ / "once/cycle.csv"} << "mine";
    const Outcome again = exported("-o once --what periods,cycle");
    EXPECT_EQ(again.status, 2);
    EXPECT_NE(again.err.find("cycle.csv: exists already"), std::string::npos) << again.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "once/periods.csv"));
    std::ifstream in{folder_ / "once/cycle.csv"};
    std::string text;
    std::getline(in, text);
    EXPECT_EQ(text, "mine");
    const Outcome unknown = exported("-o none --what results,nonsense");
    EXPECT_EQ(unknown.status, 2);
    EXPECT_NE(unknown.err.find("nonsense"), std::string::npos) << unknown.err;
    EXPECT_NE(unknown.err.find("accelerometer"), std::string::npos) << unknown.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "none"));
}

TEST_F(ExportedRun, UnreadableRecordingLeavesNoFiles) {
    std::filesystem::copy_file(folder_ / "run.nxs", folder_ / "bent.nxs");
    python("bend.py", "import h5py\nh5py.File('bent.nxs', 'r+')['entry/raw/drive/changes/phase'][3] += 1\n");
    const Outcome bent = shakerd("export bent.nxs --what results,drive", folder_);
    EXPECT_EQ(bent.status, 2);
    EXPECT_NE(bent.err.find("raw/drive/changes row 3"), std::string::npos) << bent.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "bent.export"));
}

// Simulates a full disk: writing fails beyond a given length.
TEST_F(ExportedRun, FailedWriteIsDiskErrorAndLeavesNoFile) {
    const std::string command = "cd '" + folder_.string() + "' && trap '' XFSZ && ulimit -f 100 && " +
                                test::build_dir() + "/shakerd export run.nxs -o full >full.out 2>full.err";
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 3);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "full"));
}

TEST_F(ExportedRun, UnfinishedRecordingIsRefusedWithAdvice) {
    recorded::RecordingHeader header;
    header.title = "cut";
    recorded::RecordingWriter unfinished{folder_ / "left.nxs.part", header};
    unfinished.flush();
    std::filesystem::copy_file(folder_ / "left.nxs.part", folder_ / "crashed.nxs.part");
    for (const auto& [name, words] :
         {std::pair{"left", "is being recorded by process"}, std::pair{"crashed", "shakerd recover"}}) {
        const Outcome o = shakerd(std::string{"export "} + name + ".nxs.part", folder_);
        EXPECT_EQ(o.status, 2);
        EXPECT_NE(o.err.find(words), std::string::npos) << o.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / (std::string{name} + ".nxs.export")));
    }
}

}  // namespace
}  // namespace shaker::exporting
