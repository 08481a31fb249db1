// A disk that fails while HDF5 writes a recording: the writer gets the error, and the file closes.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <functional>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/written_file.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

/// During its life no file can be written behind its first `bytes` bytes, or made longer.
class FullFrom {
public:
    explicit FullFrom(rlim_t bytes) {
        std::signal(SIGXFSZ, SIG_IGN);
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit now{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &now);
    }
    ~FullFrom() { ::setrlimit(RLIMIT_FSIZE, &before_); }
    FullFrom(const FullFrom&) = delete;
    FullFrom& operator=(const FullFrom&) = delete;

private:
    rlimit before_{};
};
constexpr const char* full = "File too large";

/// From now on no open descriptor of this file can be synchronised.
void break_sync(const std::filesystem::path& file) {
    std::array<int, 2> ends{};
    ASSERT_EQ(::pipe(ends.data()), 0);
    for (const auto& entry : std::filesystem::directory_iterator{"/proc/self/fd"}) {
        std::error_code closed;
        if (std::filesystem::read_symlink(entry, closed) == file)
            ::dup2(ends[1], std::stoi(entry.path().filename()));
    }
    ::close(ends[0]);
    ::close(ends[1]);
}

std::string failure(const std::function<void()>& call) try {
    call();
    return "no failure";
} catch (const DeviceError& e) {
    return e.what();
}

ssize_t open_objects() { return H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL); }

class FailingDiskTest : public testing::Test {
protected:
    FailingDiskTest() { h5::be_quiet(); }
    ~FailingDiskTest() override { EXPECT_EQ(open_objects(), before_); }

    void add(RecordingWriter& writer, int rows = 5000) {
        for (int i = 0; i < rows; ++i, ++written_)
            writer.add(PlayTime{{240 * written_}, HostTime{std::chrono::milliseconds{5} * written_}, 0});
        for (const AccelBlock& b : small_blocks()) writer.add(b);
    }
    std::size_t rows_after_recovery() {
        const auto copy = folder_ / "copy.nxs";
        std::filesystem::copy_file(file_, copy, std::filesystem::copy_options::overwrite_existing);
        RecordingWriter::mend(copy).close();
        const RecordingReader reader{copy};
        EXPECT_EQ(reader.damage(), std::vector<std::string>{});
        return reader.play_times().size();
    }
    [[nodiscard]] std::string refused() const {
        return refusal([&] { RecordingReader{file_}; });
    }

    SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "run.nxs.part";
    std::int64_t written_ = 0;
    ssize_t before_ = std::max<ssize_t>(0, open_objects());
};

TEST_F(FailingDiskTest, WriteErrorIsReportedAndFileCloses) {
    {
        RecordingWriter writer{file_, small_header()};
        add(writer);
        writer.flush();
        {
            const FullFrom now{0};
            add(writer);
            expect_in(failure([&] { writer.flush(); }), {file_.string(), full});
        }
        add(writer);
        for (const auto& call : std::vector<std::function<void()>>{
                 [&] { writer.flush(); }, [&] { writer.sync(); }, [&] { writer.close(); }})
            expect_in(failure(call), {file_.string(), full});
        expect_in(failure([&] { static_cast<void>(writer.blocks(0, 1, 0)); }), {file_.string(), full});
    }
    EXPECT_EQ(open_objects(), before_);
    expect_in(refused(), {"its writer ended without closing it"});
    EXPECT_EQ(rows_after_recovery(), 5000U);
}

TEST_F(FailingDiskTest, FileWithoutHeadIsRemoved) {
    const std::string why = failure([&] {
        const FullFrom now{100};
        const RecordingWriter writer{file_, small_header()};
    });
    expect_in(why, {file_.string(), full});
    EXPECT_FALSE(std::filesystem::exists(file_));
    { const h5::Handle empty = h5::create_file(file_); }
    expect_in(refusal([&] { RecordingWriter::mend(file_); }), {file_.string(), "holds no data"});
}

TEST_F(FailingDiskTest, DiskFullAnywhereLeavesNoFileOpen) {
    const auto record = [&](RecordingWriter& writer) {
        for (int i = 0; i < 6; ++i) {
            add(writer, 1500);
            writer.flush();
        }
        writer.close();
    };
    {
        RecordingWriter whole{file_, small_header()};
        record(whole);
    }
    const std::uintmax_t bytes = std::filesystem::file_size(file_);
    constexpr std::uintmax_t steps = 30;
    for (std::uintmax_t i = 0; i < steps; ++i) {
        std::filesystem::remove(file_);
        const std::string why = failure([&] {
            const FullFrom now{bytes * i / steps};
            RecordingWriter writer{file_, small_header()};
            record(writer);
        });
        expect_in(why, {file_.string(), full});
        ASSERT_EQ(open_objects(), before_) << i;
    }
}

TEST_F(FailingDiskTest, DiskFailingAtAnyFlushLeavesNoFileOpen) {
    for (int good = 0; good < 8; ++good) {
        std::filesystem::remove(file_);
        {
            RecordingWriter writer{file_, small_header()};
            for (int i = 0; i < good; ++i) {
                add(writer, 700);
                writer.flush();
            }
            const FullFrom now{0};
            add(writer, 700);
            expect_in(failure([&] { writer.close(); }), {file_.string(), full});
        }
        ASSERT_EQ(open_objects(), before_) << good;
        EXPECT_EQ(rows_after_recovery(), 700U * static_cast<std::size_t>(good));
    }
}

TEST_F(FailingDiskTest, ErrorOfSynchronisationStays) {
    RecordingWriter writer{file_, small_header()};
    add(writer);
    writer.flush();
    break_sync(file_);
    for (int i = 0; i < 2; ++i)
        expect_in(failure([&] { writer.sync(); }), {file_.string(), "Invalid argument"});
    expect_in(failure([&] { writer.close(); }), {file_.string(), "Invalid argument"});
}

TEST_F(FailingDiskTest, ErrorWhileHdf5ClosesIsReported) {
    h5::Handle file = h5::create_file(file_);
    h5::flush(file.get(), file_.string());
    break_sync(file_);
    expect_in(failure([&] { h5::close_file(std::move(file), file_.string()); }),
              {file_.string(), "Illegal seek"});
}

TEST_F(FailingDiskTest, FirstErrorEndsAllChangesOfTheFile) {
    using Kind = h5::WrittenFile::Kind;
    const std::string old = "0123456789", other = "abcd";
    const auto bytes = [](const std::string& text) { return std::as_bytes(std::span{text}); };
    h5::WrittenFile file{::open(folder_.write("bytes", old).c_str(), O_RDWR | O_CLOEXEC)};
    file.require_whole("bytes");
    {
        const FullFrom now{old.size()};
        file.set_length(50);
    }
    expect_in(failure([&] { file.require_whole("bytes"); }), {"bytes: ", full});
    file.write(2, bytes(other), Kind::metadata);
    file.write(4, bytes("XY"), Kind::metadata);
    file.write(7, bytes("lost"), Kind::data);
    file.set_length(12);
    file.leave();
    std::string read(12, '?');
    EXPECT_TRUE(file.read(0, std::as_writable_bytes(std::span{read})));
    EXPECT_EQ(read, (std::string{"01abXY6789\0\0", 12}));
    EXPECT_EQ(file.length(), 12U);
    EXPECT_EQ(std::filesystem::file_size(folder_ / "bytes"), old.size());
    file.sync();
    expect_in(failure([&] { file.require_whole("bytes"); }), {"bytes: ", full});
}

TEST_F(FailingDiskTest, OtherFilesWorkAfterAFailure) {
    {
        RecordingWriter writer{file_, small_header()};
        add(writer);
        const FullFrom now{0};
        expect_in(failure([&] { writer.flush(); }), {full});
    }
    for (const char* name : {"second.nxs", "third.nxs"}) {
        RecordingWriter writer{folder_ / name, small_header()};
        add(writer, 1000);
        writer.close();
        EXPECT_EQ(RecordingReader{folder_ / name}.play_times().size(), 1000U);
    }
}

TEST_F(FailingDiskTest, AbandonedRecordingStaysUnfinished) {
    {
        RecordingWriter writer{file_, small_header()};
        add(writer);
        writer.flush();
        add(writer);
    }
    expect_in(refused(), {"its writer ended without closing it"});
    EXPECT_EQ(rows_after_recovery(), 5000U);
}

}  // namespace
}  // namespace shaker::recorded
