// A recording is completed after a crash, with verified data only.
#include <gtest/gtest.h>

#include <fstream>

#include "daemon/recording/tables/reduction_tables.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::recording {

using namespace test;
namespace {

using test::expect_in;
using test::fresh_folder;
using test::Outcome;
using test::shakerd;

// A run as after a crash at its end: finished, then renamed to the unfinished name.
class RecoverTest : public ::testing::Test {
protected:
    RecoverTest() {
        std::ofstream{folder_ / "slow.toml"} << "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n";
        const Outcome o =
            shakerd("run --no-identify --scene slow.toml --gamma 1.2g --periods 4 --frames region -o run.nxs",
                    folder_);
        EXPECT_EQ(o.status, 0) << o.err;
        std::filesystem::rename(folder_ / "run.nxs", folder_ / "whole.nxs");
        std::filesystem::copy_file(folder_ / "whole.nxs", folder_ / "run.nxs.part");
    }
    // Changes bytes of a column of the unfinished file.
    void damage(const std::string& path, hsize_t row) {
        const h5::Handle file{H5Fopen((folder_ / "run.nxs.part").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
        const h5::Handle set{H5Dopen2(file.get(), ("entry/" + path).c_str(), H5P_DEFAULT), path};
        const h5::Handle space{H5Dget_space(set.get()), path};
        const hsize_t one = 1;
        h5::check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &row, nullptr, &one, nullptr), path);
        const h5::Handle memory{H5Screate_simple(1, &one, nullptr), path};
        const std::int64_t wrong = 123456789;
        h5::check(H5Dwrite(set.get(), H5T_NATIVE_INT64, memory.get(), space.get(), H5P_DEFAULT, &wrong),
                  path);
    }
    std::filesystem::path folder_ = fresh_folder();
};

TEST_F(RecoverTest, IntactFileIsRecoveredWithEveryRow) {
    const Outcome o = shakerd("recover run.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    const recorded::RecordingReader whole{folder_ / "whole.nxs"}, back{folder_ / "run.nxs"};
    EXPECT_EQ(back.play_times().size(), whole.play_times().size());
    EXPECT_EQ(back.changes().size(), whole.changes().size());
    EXPECT_EQ(back.numbers("tracks/top/walker/x_px"), whole.numbers("tracks/top/walker/x_px"));
    EXPECT_EQ(back.pictures_of("top"), whole.pictures_of("top"));
    EXPECT_EQ(back.damage(), std::vector<std::string>{});
    expect_in(back.text("process/recovered"), {"without closing"});
    EXPECT_EQ(shakerd("replay run.nxs", folder_).status, 0);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "run.nxs.part")) << "the .part file must stay";
}

TEST_F(RecoverTest, SecondRecoveryFindsItIntact) {
    ASSERT_EQ(shakerd("recover run.nxs.part", folder_).status, 0);
    const Outcome again = shakerd("recover run.nxs.part", folder_);
    EXPECT_EQ(again.status, 0);
    expect_in(again.out, {"run.nxs: finished recording, intact"});
}

TEST_F(RecoverTest, FollowsNoLinkWhereItWrites) {
    const std::filesystem::path victim = folder_ / "victim", link = folder_ / "run.nxs.unfinished";
    std::ofstream{victim} << "mine";
    std::filesystem::create_symlink(victim, folder_ / "run.nxs.recovering");  // the name of older versions
    std::filesystem::create_symlink(victim, link);
    const Outcome refused = shakerd("recover run.nxs", folder_);
    EXPECT_EQ(refused.status, 2);
    expect_in(refused.err, {"run.nxs.unfinished: exists"});
    std::filesystem::remove(link);
    EXPECT_EQ(shakerd("recover run.nxs", folder_).status, 0);
    EXPECT_EQ(std::filesystem::file_size(victim), 4U);
    EXPECT_FALSE(std::filesystem::exists(link));
}

TEST_F(RecoverTest, DataAfterDamageAreOmitted) {
    const std::size_t rows = recorded::RecordingReader{folder_ / "whole.nxs"}.play_times().size();
    damage("raw/drive/play_heard", rows / 2);
    const Outcome o = shakerd("recover run.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    const recorded::RecordingReader back{folder_ / "run.nxs"};
    const std::vector<PlayTime> played = back.play_times(),
                                was = recorded::RecordingReader{folder_ / "whole.nxs"}.play_times();
    EXPECT_LT(played.size(), rows / 2 + 1);
    EXPECT_GT(played.size(), rows / 2 - 101) << "at most half a second may be lost";
    for (std::size_t i = 0; i < played.size(); ++i) EXPECT_EQ(played[i].heard, was[i].heard);
    EXPECT_EQ(back.damage(), std::vector<std::string>{});
}

TEST_F(RecoverTest, DamagedPictureIsReportedAndRemoved) {
    const std::filesystem::path file = folder_ / "run.frames" / "top-0000.h5";
    {
        std::fstream bytes{file, std::ios::in | std::ios::out | std::ios::binary};
        bytes.seekp(-5000000, std::ios::end);
        bytes.put('\1');
        bytes.put('\2');
    }
    const Outcome o = shakerd("recover run.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    expect_in(o.out, {"1 pictures lost", "camera \"top\": picture"});
    const recorded::RecordingReader back{folder_ / "run.nxs"};
    EXPECT_EQ(back.frames_without_picture(), 1U);
    EXPECT_EQ(back.scalar("pictures/top/dropped"), 1);
    EXPECT_EQ(back.scalar("pictures/top/produced"),
              back.scalar("pictures/top/stored") + back.scalar("pictures/top/dropped"));
    const Outcome raw = shakerd("replay --from raw run.nxs", folder_);
    EXPECT_EQ(raw.status, 2);
    expect_in(raw.err, {"--from raw", "not all pictures"});
    EXPECT_EQ(shakerd("replay run.nxs", folder_).status, 0);
}

// Pictures of the first second only: the others are no loss, and the file replays from its tracks.
TEST_F(RecoverTest, PicturesThatWereNotKeptAreNotMissed) {
    ASSERT_EQ(
        shakerd("run --no-identify --scene slow.toml --gamma 1.2g --periods 4 -o first.nxs", folder_).status,
        0);
    std::filesystem::rename(folder_ / "first.nxs", folder_ / "first.nxs.part");
    const Outcome o = shakerd("recover first.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    expect_in(o.out, {"400 pictures, 0 pictures lost"});
    const recorded::RecordingReader back{folder_ / "first.nxs"};
    EXPECT_EQ(back.damage(), std::vector<std::string>{});
    EXPECT_EQ(back.header().pictures, recorded::KeptPictures::first_second);
    EXPECT_EQ(back.scalar("pictures/top/stored"), 200);
    expect_in(shakerd("recover first.nxs", folder_).out, {"finished recording, intact"});
    expect_in(shakerd("replay first.nxs", folder_).out, {"identical"});
}

TEST_F(RecoverTest, ChangedFinishedFileIsReportedNotModified) {
    damage("raw/drive/play_heard", 7);
    std::filesystem::rename(folder_ / "run.nxs.part", folder_ / "run.nxs");
    const Outcome o = shakerd("recover run.nxs", folder_);
    EXPECT_EQ(o.status, 4);
    expect_in(o.out, {"damaged from row", "raw/drive/play_heard"});
}

TEST_F(RecoverTest, LastPicturesThatAreGoneAreReported) {
    std::filesystem::rename(folder_ / "run.nxs.part", folder_ / "run.nxs");
    const std::filesystem::path frames = folder_ / "run.frames";
    const std::uint64_t last = pictures::verify_frames(frames, "top").last;
    pictures::end_frames(frames, "top", last - 5);
    const Outcome o = shakerd("recover run.nxs", folder_);
    EXPECT_EQ(o.status, 4);
    const std::string sentence =
        "camera \"top\": 5 pictures, the first is number " + std::to_string(last - 4) + ", are in no file";
    expect_in(o.out, {"CHANGED since it was written", sentence.c_str()});
    expect_in(shakerd("recover --json run.nxs", folder_).out, {"\"pictures_lost\": 5"});
    std::filesystem::remove_all(frames);
    const Outcome none = shakerd("recover run.nxs", folder_);
    EXPECT_EQ(none.status, 4);
    expect_in(none.out, {" 0 pictures", "run.frames: no pictures of camera \"top\""});
}

TEST_F(RecoverTest, FolderOfPicturesThatIsALinkIsRefused) {
    const std::filesystem::path others = folder_ / "others.frames";
    std::filesystem::rename(folder_ / "run.frames", others);
    std::filesystem::create_directory_symlink(others, folder_ / "run.frames");
    const Outcome o = shakerd("recover run.nxs", folder_);
    EXPECT_EQ(o.status, 2);
    expect_in(o.err, {"run.frames: is a link"});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "run.nxs"));
}

// A copy of the .part, under another name, of a recording that goes on.
TEST_F(RecoverTest, PicturesOfALiveRecordingStay) {
    std::filesystem::rename(folder_ / "run.nxs.part", folder_ / "run.copy.part");
    const auto recorder = h5::FileLock::take_folder(folder_ / "run.frames", h5::Sharing::shared);
    const Outcome o = shakerd("recover run.copy.part", folder_);
    EXPECT_EQ(o.status, 2);
    expect_in(o.err, {"run.frames: another process records or recovers these pictures"});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "run.copy"));
}

TEST_F(RecoverTest, MissingFileIsRefusedByName) {
    const Outcome o = shakerd("recover none.nxs", folder_);
    EXPECT_EQ(o.status, 2);
    expect_in(o.err, {"none.nxs", "none.nxs.part"});
}

TEST_F(RecoverTest, NoRecordingOrCrashedFileIsOverwritten) {
    const Outcome left = shakerd("run --no-identify --periods 4 --frames region -o run.nxs", folder_);
    EXPECT_EQ(left.status, 2);
    expect_in(left.err, {"run.nxs.part", "recover"});
    const Outcome there = shakerd("run --no-identify --periods 4 --frames region -o whole.nxs", folder_);
    EXPECT_EQ(there.status, 2);
    expect_in(there.err, {"whole.nxs", "exists already"});
}

TEST_F(RecoverTest, OtherSettingsPrintChanges) {
    ASSERT_EQ(shakerd("recover run.nxs", folder_).status, 0);
    const Outcome o = shakerd("replay --from tracks --set top.mm_per_px=0.2 whole.nxs", folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    expect_in(o.out, {"with other settings", "results/v_D", "->"});
    const Outcome unknown = shakerd("replay --set colour=3 whole.nxs", folder_);
    EXPECT_EQ(unknown.status, 2);
    expect_in(unknown.err, {"colour", "top.mm_per_px", "from_s"});
    const Outcome far = shakerd("replay --set top.mm_per_px=-1 whole.nxs", folder_);
    EXPECT_EQ(far.status, 2);
    expect_in(far.err, {"top.mm_per_px", "-1"});
}

}  // namespace
}  // namespace shaker::recording
