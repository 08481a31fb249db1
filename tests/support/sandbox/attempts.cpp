#include "tests/support/sandbox/attempts.hpp"

#include <fcntl.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/support/program.hpp"

namespace shaker::test {

namespace fs = std::filesystem;

std::string word(int outcome) {
    if (outcome == succeeded) return "SUCCEEDED";
    if (outcome == died) return "killed";
    const char* name = strerrorname_np(outcome);
    return name == nullptr ? std::to_string(outcome) : name;
}

int outcome_of(const sandbox::Confinement& allowed, const Call& call) {
    testing::internal::CaptureStderr();
    const sandbox::ChildEnd end =
        run_confined("some.nxs", allowed, [&] { return call() < 0 ? errno : succeeded; });
    testing::internal::GetCapturedStderr();
    return end.signal == 0 ? end.status : 128 + end.signal;
}

int opened(const fs::path& file, int flags) { return ::open(file.c_str(), flags, 0600); }

AttemptsTest::AttemptsTest() : home_{fresh_folder()} {
    fs::create_directories(out_);
    fs::create_directories(own_ / "run.frames");
    std::ofstream{secret_} << "private";
    std::ofstream{recording_} << "data";
    std::ofstream{own_ / "run.frames" / "top-0000.h5"} << "pictures";
    fs::create_symlink("../../secret", own_ / "run.frames" / "link");
}

void AttemptsTest::TearDown() {
    std::string left;
    std::ifstream{secret_} >> left;
    EXPECT_EQ(left, "private");
    EXPECT_EQ(std::distance(fs::directory_iterator{home_}, {}), 2);
}

sandbox::Confinement AttemptsTest::rights(bool writer) const {
    sandbox::Confinement allowed = sandbox::confinement_for(recording_);
    allowed.warns = false;
    if (writer) allowed.files.writes = {out_};
    return allowed;
}

void AttemptsTest::expect_refused(const std::vector<Attempt>& attempts) const {
    for (const bool writer : {false, true})
        for (const Attempt& a : attempts) {
            const int expected = writer && a.writer >= 0 ? a.writer : a.reader;
            const int seen = outcome_of(rights(writer), a.call);
            EXPECT_EQ(word(seen), word(expected)) << (writer ? "writer: " : "reader: ") << a.name;
        }
}

}  // namespace shaker::test
