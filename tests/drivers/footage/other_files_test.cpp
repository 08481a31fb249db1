// A recording must not refer to anything outside itself: no links, no addresses, no code to load.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/recording/hdf5_structure.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::footage {

using namespace test;
namespace {

class OtherFilesTest : public testing::Test {
protected:
    OtherFilesTest() {
        write_session(small_session(), file_);
        write_session(small_session(), folder_ / "other.h5");
    }
    /// Refusal after Python replaced `path` by a link.
    std::string refusal_of_link(const std::string& path, const std::string& link) {
        write_session(small_session(), file_);
        const std::string change =
            "cd '" + (folder_ / ".").string() +
            "' && /usr/bin/python3 -c \"import h5py; f = h5py.File('small.h5', 'r+')['entry']; " + "del f['" +
            path + "']; f['" + path + "'] = h5py." + link + "\"";
        EXPECT_EQ(std::system(change.c_str()), 0) << change;
        return refusal([&] { read_session(file_); });
    }

    SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "small.h5";
};

// The other file is valid: if it were read, there would be no refusal.
TEST_F(OtherFilesTest, RefusesLinkToOtherFile) {
    for (const std::string path : {"results/v_D", "raw/drive/changes/phase", "raw/accelerometer", "title"})
        expect_in(refusal_of_link(path, "ExternalLink('other.h5', '/entry/" + path + "')"),
                  {path.substr(0, path.rfind('/')), "link to another file"});
    expect_in(refusal_of_link("tracks/top", "ExternalLink('other.h5', '/entry/tracks/top')"), {"tracks/top"});
    expect_in(refusal_of_link("results", "ExternalLink('other.h5', '/entry/results')"),
              {"results/v_D", "link to another file"});
}

TEST_F(OtherFilesTest, FollowsInternalLinksExceptLoops) {
    EXPECT_EQ(refusal_of_link("process/kind", "SoftLink('/entry/title')"), "accepted");
    expect_in(refusal_of_link("results/v_D", "SoftLink('/entry/results/v_D')"), {"results/v_D"});
    expect_in(refusal_of_link("results/v_D", "SoftLink('/nowhere')"), {"results/v_D"});
}

TEST_F(OtherFilesTest, NoCodeIsLoaded) {
    const recorded::RecordingReader reader{file_};
    unsigned kinds = H5PL_ALL_PLUGIN;
    ASSERT_GE(H5PLget_loading_state(&kinds), 0);
    EXPECT_EQ(kinds, 0U);
}

/// Exit status of a child that reads `file`: 0 accepted, 2 refused; 128 + n when signal n ended it.
int end_of_reading(const std::filesystem::path& file) {
    const pid_t child = fork();
    if (child == 0) {
        mallopt(M_PERTURB, 0x55);  // uninitialised memory never looks like a valid address
        _exit(refusal([&] { read_session(file); }) == "accepted" ? 0 : 2);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Every pointer to a block with a checksum is changed, one at a time, and the checksums are corrected. A
// pointer of all ones means "no block", which HDF5's own drivers copied from a null pointer. Every eighth
// pointer, nightly each one, also gets an address outside of the file.
TEST_F(OtherFilesTest, AddressesOutsideOfTheFileAreRefused) {
    const std::string bytes = bytes_of(file_);
    const test::Structure structure = test::structure_of(file_);
    ASSERT_GT(structure.sealed.size(), 50U);
    const int share = test::nightly() ? 1 : 8;
    int pointers = 0, bent = 0, refused = 0;
    for (const test::Stretch& block : structure.sealed) {
        if (block.begin == 0) continue;  // the superblock at 0; too many other values are 0
        for (std::size_t at = bytes.find(little_endian(block.begin, 8)); at != std::string::npos;
             at = bytes.find(little_endian(block.begin, 8), at + 1)) {
            const bool also_outside = pointers++ % share == 0;
            for (const std::uint64_t address : {UINT64_MAX, std::uint64_t{bytes.size()} - 2}) {
                if (address != UINT64_MAX && !also_outside) continue;
                std::string mutant = bytes;
                mutant.replace(at, 8, little_endian(address, 8));
                test::seal(mutant, structure);
                const int end = end_of_reading(folder_.write("bent.h5", mutant));
                EXPECT_LT(end, 128) << "at " << at << ": " << address;
                ++bent;
                refused += end == 2 ? 1 : 0;
            }
        }
    }
    EXPECT_GT(pointers, 100);
    EXPECT_GT(refused, bent / 2) << "some of what is bent is never asked for";
}

// The byte before a link's name is its length.
TEST_F(OtherFilesTest, AGroupWithALinkThatCannotBeReadIsRefused) {
    const std::string bytes = bytes_of(file_);
    const test::Structure structure = test::structure_of(file_);
    int damaged = 0;
    for (const std::string name : {"x_errors", "walker", "base", "targets", "v_D"})
        for (std::size_t at = bytes.find(std::string{static_cast<char>(name.size())} + name);
             at != std::string::npos;
             at = bytes.find(std::string{static_cast<char>(name.size())} + name, at + 1)) {
            std::string mutant = bytes;
            mutant[at] = '\xff';
            test::seal(mutant, structure);
            EXPECT_EQ(end_of_reading(folder_.write("link.h5", mutant)), 2) << name << " at " << at;
            ++damaged;
        }
    EXPECT_GE(damaged, 5);
}

}  // namespace
}  // namespace shaker::footage
