// A recording in progress belongs to its writer: nobody recovers, replaces or joins it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "daemon/recording/folder.hpp"
#include "daemon/recording/recorder.hpp"
#include "daemon/recording/tables/places.hpp"
#include "drivers/recorded/pictures/segment.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/many_pictures.hpp"

namespace shaker::recording {
namespace {

using test::expect_in;
using test::refusal;

constexpr pictures::PictureShape shape{64, 48, 1};

recorded::RecordingHeader header() {
    recorded::RecordingHeader h = test::small_header();
    h.pictures = recorded::KeptPictures::full;
    h.groups = recording_places(h, false);
    return h;
}

class LiveFileTest : public testing::Test {
protected:
    // Adds pictures to both cameras and writes them.
    void record(std::uint64_t from, std::uint64_t to) {
        for (std::uint64_t n = from; n <= to; ++n)
            for (std::size_t camera = 0; camera < 2; ++camera) {
                const std::vector<tracking::Track> tracks(header().views[camera].targets.size());
                recorder_->add(camera, test::numbered(n, shape), tracks, {});
                recorder_->step();
            }
    }
    [[nodiscard]] std::vector<std::filesystem::path> segments() const {
        return pictures::segment_files(folder_ / "run.frames", "top");
    }
    // The segment of the pictures to come is made beside the recording.
    void wait_for_spare() const {
        while (segments().size() < 2) ::usleep(1000);
    }

    std::filesystem::path folder_ = test::fresh_folder();
    std::filesystem::path file_ = folder_ / "run.nxs";
    std::unique_ptr<Recorder> recorder_ =
        std::make_unique<Recorder>(file_, header(), RecorderSettings{.live = true});
    std::string process_ = "is being recorded by process " + std::to_string(::getpid());
};

TEST_F(LiveFileTest, RecoverRefusesItAndRemovesNothing) {
    record(1, 20);
    wait_for_spare();
    for (const char* name : {"run.nxs", "run.nxs.part"}) {
        const test::Outcome o = test::shakerd(std::string{"recover "} + name, folder_);
        EXPECT_EQ(o.status, 2);
        expect_in(o.err, {"run.nxs.part", process_});
    }
    EXPECT_EQ(segments().size(), 2U) << "the spare segment";
    EXPECT_FALSE(std::filesystem::exists(file_));
    record(21, 40);
    recorder_->finish(acquisition::Streams{});
    const test::Outcome o = test::shakerd("recover --json run.nxs", folder_);
    EXPECT_EQ(o.status, 0) << o.out << o.err;
    expect_in(o.out, {"\"pictures\": 80", "\"pictures_lost\": 0"});
}

TEST_F(LiveFileTest, ReplayAndExportNameItsWriter) {
    for (const char* command : {"replay run.nxs.part", "export run.nxs.part"}) {
        const test::Outcome o = test::shakerd(command, folder_);
        EXPECT_EQ(o.status, 2);
        expect_in(o.err, {"run.nxs.part", process_});
    }
}

TEST_F(LiveFileTest, SecondRecorderIsRefused) {
    expect_in(refusal([&] { Recorder{file_, header(), {}}; }), {"run.nxs.part", process_, "another name"});
    record(1, 3);
    recorder_->finish(acquisition::Streams{});
    EXPECT_TRUE(std::filesystem::exists(file_));
}

TEST_F(LiveFileTest, FileThatTookTheNameStays) {
    record(1, 9);
    std::ofstream{file_} << "another program's";
    try {
        recorder_->finish(acquisition::Streams{});
        FAIL() << "it was replaced";
    } catch (const DeviceError& e) {
        expect_in(e.what(), {"run.nxs.part cannot be renamed to", "run.nxs: another file", "recover"});
    }
    recorder_.reset();
    EXPECT_EQ(std::filesystem::file_size(file_), 17U);
    std::filesystem::rename(file_, folder_ / "other");
    const test::Outcome o = test::shakerd("recover --json run.nxs", folder_);
    EXPECT_EQ(o.status, 0) << o.err;
    expect_in(o.out, {"\"pictures\": 18", "\"pictures_lost\": 0"});
}

TEST_F(LiveFileTest, FolderBelongsToOneDaemon) {
    const h5::FileLock lock = lock_folder(folder_);
    EXPECT_TRUE(lock.held());
    expect_in(refusal([&] { lock_folder(folder_); }),
              {folder_.string(), "process " + std::to_string(::getpid()) + " records into this folder"});
    const test::Outcome o =
        test::shakerd("serve --rig sim: --http-port 0 --scpi-port 0 --recordings .", folder_);
    EXPECT_EQ(o.status, 2);
    expect_in(o.err, {"records into this folder"});
}

}  // namespace
}  // namespace shaker::recording
