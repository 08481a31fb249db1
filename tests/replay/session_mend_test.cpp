// A power cut may tear any block of a file that was being written: what can still be read is kept, the rest
// costs its own rows and nothing else.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "drivers/replay/h5.hpp"
#include "drivers/replay/opened_session.hpp"
#include "drivers/replay/seals.hpp"
#include "tests/replay/small_session.hpp"

namespace shaker::session_test {
namespace {

// Enough rows for an index of several blocks.
Session long_session() {
    Session s = small_session();
    const PlayTime last = s.played.back();
    for (std::int64_t i = 1; i <= 30000; ++i)
        s.played.push_back({{last.tick.n + 240 * i}, last.heard + std::chrono::milliseconds{5} * i, 0});
    return s;
}

std::vector<std::size_t> places_of(const std::string& bytes, const std::string& signature) {
    std::vector<std::size_t> places;
    for (std::size_t at = bytes.find(signature); at != std::string::npos; at = bytes.find(signature, at + 1))
        places.push_back(at);
    return places;
}

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

class SessionMendTest : public ::testing::Test {
protected:
    SessionMendTest() {
        write_session(long_session(), folder_ / "whole.nxs");
        whole_ = bytes_of(folder_ / "whole.nxs");
    }
    // Columns and their rows after the mending of a file with these bytes, each a beginning of the written
    // one.
    std::map<std::string, std::size_t> mended(const std::string& bytes) {
        const std::filesystem::path file = folder_.write("torn.nxs", bytes);
        SessionWriter::mend(file).close();
        SessionWriter again = SessionWriter::mend(file);  // as recovery does, which adds what it found
        again.rows("tracks/top/walker", {{"t", "s", {9}}, {"x", "m", {9}}, {"x_errors", "m", {9}}});
        again.close();
        const SessionReader is{file}, was{folder_ / "whole.nxs"};
        EXPECT_EQ(is.damage(), std::vector<std::string>{});
        std::map<std::string, std::size_t> rows;
        for (const SealedColumn& c : read_seals(is.opened().entry.get())) {
            if (h5::description_of(is.opened().entry.get(), c.path).shape.empty()) continue;  // told once
            const h5::Bytes a = h5::read_bytes(is.opened().entry.get(), c.path),
                            b = h5::read_bytes(was.opened().entry.get(), c.path);
            const std::size_t added = c.path.starts_with("tracks/") ? a.row : 0;
            rows[c.path] = (a.values.size() - added) / a.row;
            EXPECT_LE(a.values.size() - added, b.values.size()) << c.path;
            EXPECT_TRUE(std::equal(a.values.begin(), a.values.end() - static_cast<std::ptrdiff_t>(added),
                                   b.values.begin()))
                << c.path;
        }
        return rows;
    }
    SessionFolder folder_;
    std::string whole_;
};

TEST_F(SessionMendTest, AWholeFileKeepsEveryRow) {
    const auto rows = mended(whole_);
    EXPECT_EQ(rows.at("raw/drive/play_tick"), long_session().played.size());
    EXPECT_EQ(rows.at("raw/accelerometer/block_first"), long_session().blocks.size());
}

TEST_F(SessionMendTest, AnyTornBlockOfAnIndexCostsNoMoreThanItsFamily) {
    const auto all = mended(whole_);
    for (const char* kind : {"EAHD", "EAIB", "EADB"}) {
        const std::vector<std::size_t> places = places_of(whole_, kind);
        EXPECT_GT(places.size(), 0U) << kind;
        int of_all = 0;  // the seals' own index: nothing behind it can be vouched for
        for (const std::size_t at : places) {
            SCOPED_TRACE(testing::Message() << kind << " at " << at);
            std::string torn = whole_;
            std::fill_n(torn.begin() + static_cast<std::ptrdiff_t>(at), 16, '\0');
            std::set<std::string> families;
            for (const auto& [path, rows] : mended(torn)) {
                const std::string group = path.substr(0, path.rfind('/'));
                if (std::string{"EADB"} == kind && rows != all.at(path))
                    EXPECT_GE(rows, 2048U) << path << ": the first chunks are known to the index itself";
                if (rows != all.at(path)) families.insert(group == "tracks/top/walker" ? "raw/top" : group);
            }
            of_all += families.size() > 1 ? 1 : 0;
        }
        EXPECT_LE(of_all, 4) << kind << ": the seals have four columns of one block";
    }
}

}  // namespace
}  // namespace shaker::session_test
