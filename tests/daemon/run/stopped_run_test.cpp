// Files of a stopped run after the end of the program.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/recording/tables/trip_table.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recording_folder.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::run {

using namespace test;
namespace {

using nlohmann::json;
using test::all_frames;
using test::expect_in;
using test::fresh_folder;
using test::Outcome;
using test::shakerd;

// A bench with these cameras whose accelerometer fails at at_s.
std::filesystem::path bench(const std::string& what, double at_s, const char* cameras = test::slow) {
    auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << cameras << "[[fault]]\nat_s = " << at_s << "\nwhat = \"" << what
                                         << "\"\n";
    return folder;
}

Outcome stopped(const std::string& options, const std::filesystem::path& folder) {
    Outcome o = shakerd("run --scene scene.toml " + options, folder);
    EXPECT_EQ(o.status, 5) << o.err;
    return o;
}

// The only file of this kind in a folder.
std::filesystem::path only_trip(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (entry.path().filename().string().starts_with("trip-") && entry.path().extension() == ".nxs")
            found.push_back(entry.path());
    EXPECT_EQ(found.size(), 1U);
    return found.empty() ? std::filesystem::path{} : found.front();
}

struct Pictures {
    std::vector<std::int64_t> ticks;
    std::vector<std::vector<std::byte>> pixels;
};

Pictures pictures(const std::filesystem::path& file, std::size_t camera) {
    const recorded::RecordingReader reader{file};
    const Rig rig = replay_rig(reader, reader.header(), true);
    Pictures p;
    for (const FramePtr& f : all_frames(*rig.cameras.at(camera))) {
        p.ticks.push_back(f->tick.n);
        p.pixels.push_back(f->pixels);
    }
    return p;
}

// Tail pictures beside a recording without pictures.
Pictures tail(const std::filesystem::path& file, const std::string& camera) {
    pictures::PictureReader reader{recorded::pictures_folder(file), camera + "-tail"};
    Pictures p;
    for (std::uint64_t i = 0; i < reader.count(); ++i) {
        const FramePtr frame = reader.read(i);
        p.ticks.push_back(frame->tick.n);
        p.pixels.push_back(frame->pixels);
    }
    return p;
}

// The elements of `all` from the first one of `some` on.
void expect_end_of(const Pictures& all, const Pictures& some) {
    ASSERT_FALSE(some.ticks.empty());
    const auto at = std::ranges::find(all.ticks, some.ticks.front()) - all.ticks.begin();
    ASSERT_EQ(all.ticks.size() - static_cast<std::size_t>(at), some.ticks.size());
    for (std::size_t i = 0; i < some.ticks.size(); ++i) {
        EXPECT_EQ(all.ticks[static_cast<std::size_t>(at) + i], some.ticks[i]);
        ASSERT_TRUE(all.pixels[static_cast<std::size_t>(at) + i] == some.pixels[i]) << i;
    }
}

// 2 s before the trip and 0.3 s after it; 200 pictures a second.
TEST(StoppedRunTest, TailPicturesAreTheRenderedOnes) {
    const auto folder = bench("saturated", 2.6, test::rendered);
    stopped("-o full.nxs --frames full", folder);
    stopped("-o lean.nxs --frames off", folder);
    const Outcome o = stopped("", folder);
    const auto trip = only_trip(folder);
    expect_in(o.err, {"the drive was stopped", "acceleration", trip.filename().string()});
    for (const std::size_t camera : {0U, 1U}) {
        const Pictures all = pictures(folder / "full.nxs", camera), last = pictures(trip, camera);
        EXPECT_GE(last.ticks.size(), 458U);
        EXPECT_LE(last.ticks.size(), 466U);
        EXPECT_GT(last.ticks.front(), 118);
        expect_end_of(all, last);
        const Pictures beside = tail(folder / "lean.nxs", camera == 0 ? "top" : "side");
        EXPECT_GE(beside.ticks.size(), 498U);
        expect_end_of(all, beside);
    }
    const Outcome replay = shakerd("replay " + trip.filename().string(), folder);
    EXPECT_EQ(replay.status, 0) << replay.err;
    EXPECT_TRUE(replay.out.starts_with("a limit stopped this run at 2.60")) << replay.out;
    expect_in(replay.out, {"no results: in state identify", "identical"});
    EXPECT_EQ(replay.out.find("v_D"), std::string::npos) << replay.out;
    EXPECT_EQ(shakerd("replay full.nxs", folder).status, 0);
}

TEST(StoppedRunTest, TailBlocksAndPlaysKeepNumbers) {
    const auto folder = bench("saturated", 2.6);
    stopped("-o full.nxs --frames off", folder);
    stopped("--trips .", folder);
    const recorded::RecordingReader full{folder / "full.nxs"}, trip{only_trip(folder)};
    std::vector<AccelBlock> all, last;
    AccelBlock block;
    for (Rig rig = replay_rig(full, full.header(), false); rig.accelerometer->read(block, test::no_wait);)
        all.push_back(block);
    for (Rig rig = replay_rig(trip, trip.header(), false); rig.accelerometer->read(block, test::no_wait);)
        last.push_back(block);
    ASSERT_LT(last.size(), all.size());
    EXPECT_GE(last.size() * 64, 2.3 * 4000 - 64);
    for (std::size_t i = 0; i < last.size(); ++i) {
        const AccelBlock& a = all[all.size() - last.size() + i];
        EXPECT_EQ(last[i].first, a.first);
        EXPECT_EQ(last[i].counts, a.counts);
        EXPECT_EQ(last[i].quality, i == 0 ? Quality::gap : a.quality);
    }
    EXPECT_EQ(trip.play_times().back().tick, full.play_times().back().tick);
    EXPECT_NEAR(static_cast<double>(trip.play_times().front().tick.n) / 48000, 0.6, 0.02);
    EXPECT_EQ(trip.header().kind, "trip");
    EXPECT_EQ(recording::read_trips(trip).size(), 1U);
    EXPECT_EQ(recording::read_trips(full).size(), 1U);
}

// A queue of 100 ms, of which 10 ms stay: the recording has the drive that was played, and replays to the
// bit.
TEST(StoppedRunTest, HardStopThatTookBackReplaysIdentically) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << "[dac]\nbuffer_s = 0.1\nkept_s = 0.01\n"
                                         << test::slow << "[[fault]]\nwhat = \"saturated\"\n"
                                         << "at_s = 11.2\nfor_s = 0.02\n";
    stopped("--periods 80 -o run.nxs --frames off", folder);
    const recorded::RecordingReader file{folder / "run.nxs"};
    const DriveChange stop = file.changes().back();
    EXPECT_GT(stop.stop, 0);
    EXPECT_GE(stop.taken_back, 85 * 48) << "all but 10 ms, at any phase of a block";
    EXPECT_LE(stop.taken_back, 90 * 48);
    const double stopped_s = static_cast<double>(stop.end().n) / 48000;
    EXPECT_LT(stopped_s, 11.2 + 0.02 + 0.01 + 0.005 + 0.005)
        << "sample, block of the sensor, what stays, ramp, block";
    double largest = 0;
    AccelBlock block;
    for (Rig rig = replay_rig(file, file.header(), false); rig.accelerometer->read(block, test::no_wait);)
        for (int i = 0; i < block.size; ++i) {
            const double t = static_cast<double>(block.first.n + i) / 4000 - 0.1;  // the queue fills first
            if (t < stopped_s + 0.05 || t > stopped_s + 0.08) continue;
            largest = std::max(largest, std::abs(file.header().accelerometer.acceleration(
                                            block.counts[static_cast<std::size_t>(i)])[0]));
        }
    EXPECT_LT(largest, 1.5) << "the base rests, while the queue would still have driven it";
    const Outcome replay = shakerd("replay run.nxs", folder);
    EXPECT_EQ(replay.status, 0) << replay.err;
    EXPECT_TRUE(replay.out.starts_with("a limit stopped this run at 11.2")) << replay.out;
    expect_in(replay.out, {"v_D", "identical"});
    EXPECT_EQ(shakerd("export run.nxs --what drive,changes", folder).status, 0);
}

TEST(StoppedRunTest, PeriodsBeforeStopAreReducedWithNote) {
    const auto folder = bench("flipped", 9.2);
    stopped("--periods 40", folder);
    const std::string name = only_trip(folder).filename().string();
    const Outcome o = shakerd("replay --json " + name, folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const json r = json::parse(o.out);
    EXPECT_EQ(r["trips"][0]["cause"], "polarity");
    EXPECT_EQ(r["trips"][0]["state"], "run");
    EXPECT_NEAR(r["trips"][0]["time_s"].get<double>(), 9.2, 0.01);
    EXPECT_NEAR(r["v_D_mps"].get<double>(), 14.528e-3, 0.01 * 14.528e-3);
    expect_in(r["notes"].dump(), {"a limit stopped the run", "periods"});
    const Outcome said = shakerd("replay " + name, folder);
    EXPECT_TRUE(said.out.starts_with("a limit stopped this run at 9.20")) << said.out;
}

TEST(StoppedRunTest, PythonReadsCauseUnitsAndIdentification) {
    if (std::system("/usr/bin/python3 -c 'import h5py' 2> /dev/null") != 0) {
        if (std::getenv("CI") != nullptr) FAIL() << "python3 has no h5py";
        GTEST_SKIP() << "python3 has no h5py";
    }
    // After the first level of the identification.
    const auto folder = bench("saturated", 5.5, test::rendered);
    stopped("-o run.nxs --frames off", folder);
    std::ofstream{folder / "look.py"} << R"(
import h5py
def name_in(attribute):
    return (attribute if isinstance(attribute, bytes) else attribute[0]).decode()
e = h5py.File("run.nxs", "r")["entry"]
t = e["trips"]
assert t["cause"][0] == b"acceleration" and t["unit"][0] == b"m/s^2" and t["stop"][0] == b"hard", t["cause"][0]
assert t["state"][0] == b"identify" and t["value"][0] > t["limit"][0] > 0 and abs(t["time"][0] - 5.5) < 0.01
assert b"acceleration" in t["words"][0]
plots = 0
def look(name, thing):
    global plots
    if thing.attrs.get("NX_class") == b"NXdata":
        signal, axis = (thing[name_in(thing.attrs[key])] for key in ("signal", "axes"))
        assert signal.ndim == 1 and signal.shape == axis.shape, name
        assert signal.attrs["units"] and axis.attrs["units"] == b"Hz"
        plots += 1
e["identification"].visititems(look)
assert plots == 6, plots  # response, up to four levels, transverse
assert 10 < e["identification/response/magnitude"][0] < 200
tail = h5py.File("run.frames/top-tail.h5", "r")["frames"]
assert tail.shape[0] > 400 and tail.ndim == 3, tail.shape
)";
    EXPECT_EQ(std::system(("cd '" + folder.string() + "' && /usr/bin/python3 look.py").c_str()), 0);
}

TEST(StoppedRunTest, MissingTripFolderIsRefused) {
    const auto folder = bench("saturated", 0.3);
    const Outcome o = shakerd("run --scene scene.toml --trips none", folder);
    EXPECT_EQ(o.status, 2);
    expect_in(o.err, {"--trips", "none"});
}

TEST(StoppedRunTest, UnwritableFileDoesNotHideCause) {
    const Outcome o = stopped("--trips /proc", bench("saturated", 0.3));
    expect_in(o.err, {"the drive was stopped", "acceleration", "nothing could be recorded", "/proc/trip-"});
}

}  // namespace
}  // namespace shaker::run
