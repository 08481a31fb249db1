// campaign.nxs is written and read back to the bit, opened by other programs, exported, and described in
// POINTS.md.
#include "daemon/campaign/points_table.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "daemon/campaign/combined_passes.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/format_page.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::campaign {
namespace {

using test::expect_in;
using test::refusal;

constexpr const char* plan = "[[series]]\nname = \"fig 3a\"\n";

// Three points: measured in two passes, failed, not begun. Numbers that a text would not keep.
PointsTable three_points() {
    PointsTable t;
    for (int n = 1; n <= 3; ++n) {
        PointRow row{.point = n, .series = "fig 3a \xCE\xB3", .repeat = 2, .partner = n == 1 ? 2 : 0};
        row.asked.phi = 0.1 * n;
        row.begun = n < 3 ? n : 0;
        for (int q = 1; q <= max_harmonics; ++q) {
            PointHarmonic h{.point = n, .measured = {.q = q, .amplitude = {}, .phase = {}}, .asked = 1.0 / q};
            if (n == 1) h.measured.amplitude = {1.0 / (3 * q), 1e-3 / q};
            t.harmonics.push_back(h);
        }
        for (int k = 0; k < cycle_phases; ++k) {
            PointPhase p{.point = n, .phase = k / double{cycle_phases}};
            if (n == 1) p.x_m = p.v_mps = p.v_base_mps = std::sin(0.1 * k), p.x_sd_m = p.v_sd_mps = 1e-3;
            t.cycle.push_back(p);
        }
        if (n == 1) {
            row.outcome = "measured";
            row.v_D = {-0.1 / 3, 1e-5};
            row.phi = {0.1 + 1e-17, 1e-4};
            row.passes = 2;
            row.recording = "r1";
            row.time = "2026-11-25T18:00:00+01:00";
        } else if (n == 2) {
            row.outcome = "failed";
            row.reason = "acceleration, \"61.2\" m/s^2";
        }
        t.points.push_back(row);
    }
    t.stick = {{1, 1, {0.1, 0.3, 0.01}}, {1, 2, {0.9, 1.1, 0.01}}};
    for (int pass = 1; pass <= 2; ++pass)
        t.passes.push_back({.point = 1,
                            .pass = pass,
                            .recording = "r1",
                            .measurement = pass,
                            .from_s = 0.1,
                            .to_s = 0.3,
                            .periods = 10,
                            .x_from_m = -0.02,
                            .v_D = {0.1 / 3, 1e-5},
                            .how = "early",
                            .reason = "edge"});
    t.passes.push_back({.point = 2, .pass = 1, .how = "failed", .reason = "a trip"});
    return t;
}

class PointsTableTest : public testing::Test {
protected:
    void write(const PointsTable& t) const { write_points(file_, "a campaign", plan, t); }
    [[nodiscard]] int python(const std::string& program) const {
        std::ofstream{folder_ / "look.py"} << program;
        return std::system(("cd '" + file_.parent_path().string() + "' && /usr/bin/python3 look.py").c_str());
    }
    const std::filesystem::path folder_ = test::fresh_folder();
    const std::filesystem::path file_ = folder_ / "campaign.nxs";
};

TEST_F(PointsTableTest, IsReadBackToTheBit) {
    const PointsTable wrote = three_points();
    write(wrote);
    const PointsTable read = read_points(file_);
    EXPECT_EQ(testing::PrintToString(differences(wrote, read)), "{}");
    EXPECT_EQ(read.points.at(0).v_D.value, -0.1 / 3);
    EXPECT_EQ(read.points.at(1).reason, three_points().points[1].reason);
    EXPECT_EQ(read.harmonics.at(17).measured.q, 2);
    EXPECT_EQ(read.cycle.at(101).phase, 0.01);
    EXPECT_TRUE(has_points(file_));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "campaign.nxs.part"));
    std::ifstream first{file_, std::ios::binary};
    const std::string bytes{std::istreambuf_iterator<char>{first}, {}};
    write(wrote);  // replaces it
    std::ifstream second{file_, std::ios::binary};
    EXPECT_EQ(bytes, (std::string{std::istreambuf_iterator<char>{second}, {}}))
        << "equal tables give equal files";
    write({});
    EXPECT_TRUE(read_points(file_).points.empty());
}

TEST_F(PointsTableTest, DifferenceNamesColumnAndPoint) {
    const PointsTable stored = three_points();
    PointsTable now = stored;
    now.points[1].v_D.value = 1;
    now.cycle[250].v_mps = 2;
    now.passes[0].reason = "stop";
    now.stick.pop_back();
    const std::vector<std::string> found = differences(stored, now);
    ASSERT_EQ(found.size(), 4U) << testing::PrintToString(found);
    EXPECT_EQ(found[0], "points/v_D of point 2: stored nan, now 1");
    EXPECT_EQ(found[1], "cycle/v of point 3: stored nan, now 2");
    EXPECT_EQ(found[2], "stick: 2 rows stored, now 1");
    EXPECT_EQ(found[3], "passes/reason of point 1: stored edge, now stop");
}

TEST_F(PointsTableTest, DamageIsRefusedWithItsPlace) {
    write(three_points());
    {
        const h5::Handle file{H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
        const h5::Handle group = h5::open_group(file.get(), "entry/cycle");
        h5::check(H5Ldelete(group.get(), "phase", H5P_DEFAULT), "phase");
        const std::vector<double> few{0.1};
        h5::write<double>(group.get(), "phase", few, {1}, "1");
    }
    expect_in(refusal([&] { read_points(file_); }),
              {file_.string(), "cycle/phase", "1 values, expected 100"});
    std::ofstream{file_} << "text";
    EXPECT_FALSE(has_points(file_));
    EXPECT_FALSE(has_points(folder_ / "none.nxs"));
}

// The default plot, the axes, and the text of the plan.
TEST_F(PointsTableTest, OpensInH5pyAndSilx) {
    if (std::system("/usr/bin/python3 -c 'import h5py, silx.io.nxdata' 2> /dev/null") != 0) {
        if (std::getenv("CI") != nullptr) FAIL() << "python3 has no h5py or no silx";
        GTEST_SKIP() << "python3 has no h5py or no silx";
    }
    write(three_points());
    EXPECT_EQ(python(R"(
import h5py, numpy as np, silx.io
from silx.io import nxdata
with silx.io.open('campaign.nxs') as f:
    plot = nxdata.get_default(f)
    assert plot is not None and plot.is_curve, plot
    assert (plot.signal_name, plot.axes_names) == ('v_D', ['phi']), (plot.signal_name, plot.axes_names)
    assert plot.errors is not None and plot.errors.shape == (3,)
    for name, signal, axes, shape in (('cycle', 'v', ['point', 'phase'], (3, 100)),
                                      ('harmonics', 'amplitude', ['point', 'q'], (3, 16))):
        assert nxdata.is_valid_nxdata(f['entry/' + name]), name
        d = nxdata.NXdata(f['entry/' + name])
        assert (d.signal_name, d.axes_names, d.signal.shape, d.errors.shape) == (signal, axes, shape, shape), d
f = h5py.File('campaign.nxs')
e = f['entry']
assert f.attrs['NX_class'] == b'NXroot' and e.attrs['NX_class'] == b'NXentry'
assert e['process/config_text'][()] == b'[[series]]\nname = "fig 3a"\n'
assert e['points/v_D'].attrs['units'] == b'm/s' and e['cycle/x'].attrs['units'] == b'm'
assert e['points/series'][0].decode() == 'fig 3a \u03b3' and e['points/outcome'][2] == b'not begun'
assert e['cycle/v'][0, 25] == e['cycle/x'][0, 25] != 0 and np.isnan(e['cycle/v'][1]).all()
for group in ('points', 'harmonics', 'cycle', 'stick', 'passes'):
    for name, data in e[group].items():
        assert data.dtype.kind == 'S' or data.attrs['units'], (group, name)
)"),
              0);
}

TEST_F(PointsTableTest, ExportWritesItsTables) {
    write(three_points());
    const test::Outcome o = test::shakerd("export campaign.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    std::ifstream in{folder_ / "campaign.export" / "points.csv"};
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 4U);
    EXPECT_TRUE(lines[0].starts_with("point [1],repeat [1],partner [1],asked_frequency [Hz],")) << lines[0];
    expect_in(lines[0], {",v_D [m/s],v_D_errors [m/s],", ",series,outcome,reason,"});
    expect_in(lines[1], {",-0.033333333333333333,"});
    expect_in(lines[2], {"\"failed\",\"acceleration, \"\"61.2\"\" m/s^2\""});
    expect_in(test::shakerd("export campaign.nxs -o x --what tracks", folder_).err,
              {"no such table", "cycle, harmonics, passes, points, stick"});
}

TEST(PointsPageTest, HasTheTablesOfTheCode) {
    test::expect_page("daemon/campaign/POINTS.md",
                      [](const std::string& now) { return test::with_tables(now, point_places()); });
}

TEST(PointsPageTest, EveryColumnHasAMeaning) {
    for (const recorded::GroupLayout& g : point_places()) {
        EXPECT_NE(g.meaning, "") << g.path;
        for (const recorded::Place& p : g.places) EXPECT_NE(p.meaning, "") << g.path << "/" << p.name;
    }
}

}  // namespace
}  // namespace shaker::campaign
