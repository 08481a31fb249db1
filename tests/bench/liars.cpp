// One instrument lies, in virtual time: the base's true motion beside what was asked and its limit, and the
// stop.
//   --seeds N (0): that many instruments and sizes drawn, besides the table
#include "tests/support/run/liars.hpp"

#include <string>

#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"

namespace {

using namespace shaker;

bench::Row row(const test::Liar& liar, const std::filesystem::path& folder, bool identify = true) {
    const test::Judged j = test::judge(liar, folder, identify);
    const bool right =
        j.beyond_s == 0 && (!liar.must_measure() || j.measured) && (!liar.must_stop() || j.trip);
    return {{"liar", liar.name},
            {"response", identify ? "identified" : "data sheet"},
            {"asked", j.asked_mm, "mm", 3},
            {"limit", j.limit_mm, "mm", 3},
            {"true, largest", j.largest_mm, "mm", 3},
            {"above 1.25 limit", j.beyond_s, "s", 3},
            {"stop", j.trip ? name(j.trip->cause) : "none"},
            {"value", j.trip ? j.trip->value : 0.0, "", 3},
            {"verdict", right ? "good" : "wrong"}};
}

}  // namespace

int main(int argc, char** argv) {
    const std::filesystem::path folder = bench::own_folder(argc, argv, "shakerd-liars");
    bench::Table table;
    for (const test::Liar& liar : test::liars())
        for (const bool identify : {true, false}) table.add(row(liar, folder, identify));
    const int seeds = bench::whole_option(argc, argv, "--seeds", 0, 0);
    for (int seed = 1; seed <= seeds; ++seed)
        table.add(row(test::drawn_liar(static_cast<unsigned>(seed)), folder));
    std::filesystem::remove_all(folder);
    table.print(argc, argv);
}
