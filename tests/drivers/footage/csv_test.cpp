#include "drivers/footage/csv.hpp"

#include "tests/support/recording/recording_folder.hpp"

namespace shaker::footage {

using namespace test;
namespace {

using test::expect_in;
using test::refusal;
using test::SessionFolder;

const std::vector<std::string> wanted{"t_s", "x"};

TEST(CsvTest, ColumnsAreFoundByNameInAnyOrder) {
    const SessionFolder folder;
    const auto table = read_csv(folder.write("a.csv", "x,other,t_s\n1,abc,0.5\n-2e3,,1\n"), wanted);
    EXPECT_EQ(table.values, (std::vector<std::vector<double>>{{0.5, 1}, {1, -2000}}));
    expect_in(table.where(1), {"a.csv:3"});
}

TEST(CsvTest, IgnoresLineEndsBlanksQuotesAndMarks) {
    const SessionFolder folder;
    const std::vector<std::vector<double>> expected{{0, 1}, {2.5, 3}};
    for (const std::string text :
         {"t_s,x\n0,2.5\n1,3", "t_s,x\r\n0,2.5\r\n1,3\r\n", "\xEF\xBB\xBFt_s,x\n0,2.5\n1,3\n\n\r\n",
          " t_s , x \n 0 ,\t2.5\n+1, +3 \n", "\"t_s\",\"x\"\n0,2.5\n1,3\n"})
        EXPECT_EQ(read_csv(folder.write("a.csv", text), wanted).values, expected) << text;
}

TEST(CsvTest, NamesMissingColumnAndExistingOnes) {
    const SessionFolder folder;
    expect_in(refusal([&] { read_csv(folder.write("a.csv", "t,x\n0,1\n"), wanted); }),
              {"a.csv:1: ", "column \"t_s\" is missing", "\"t\", \"x\""});
    expect_in(refusal([&] { read_csv(folder.write("a.csv", "t_s,x,x\n0,1,2\n"), wanted); }),
              {"column \"x\" is present 2 times"});
}

TEST(CsvTest, RefusesNonFiniteNumberWithLineAndColumn) {
    const SessionFolder folder;
    for (const std::string field :
         {"nan", "NaN", "inf", "-inf", "", "abc", "1.5x", "1 2", "1e999", "0x10", "1,5"}) {
        const auto file = folder.write("a.csv", "t_s,x\n0,1\n1," + field + "\n2,3\n");
        const std::string message = refusal([&] { read_csv(file, wanted); });
        expect_in(message, {"a.csv:3: "});
        if (field != "1,5") expect_in(message, {"column \"x\"", "\"" + field + "\" is not a finite number"});
    }
}

TEST(CsvTest, RefusesRowsOfWrongLengthWithLine) {
    const SessionFolder folder;
    expect_in(refusal([&] { read_csv(folder.write("a.csv", "t_s,x\n0,1\n1\n"), wanted); }),
              {"a.csv:3: ", "1 fields, the header has 2"});
    expect_in(refusal([&] { read_csv(folder.write("a.csv", "t_s,x\n0,1,2\n"), wanted); }),
              {"a.csv:2: ", "3 fields"});
    expect_in(refusal([&] { read_csv(folder.write("a.csv", "t_s,x\n0,1\n\n1,2\n"), wanted); }),
              {"a.csv:3: ", "blank"});
}

TEST(CsvTest, AFileWithoutRowsIsRefused) {
    const SessionFolder folder;
    expect_in(refusal([&] { read_csv(folder.write("a.csv", ""), wanted); }), {"a.csv: is empty"});
    expect_in(refusal([&] { read_csv(folder.write("a.csv", "t_s,x\n"), wanted); }),
              {"a.csv: has a header but no rows"});
    expect_in(refusal([&] { read_csv(folder / "b.csv", wanted); }), {"b.csv", "No such file"});
    expect_in(refusal([&] { read_csv(folder / "", wanted); }), {"is a folder"});
}

TEST(CsvTest, RefusesTimesThatDoNotIncrease) {
    const SessionFolder folder;
    for (const std::string time : {"1", "0.5"}) {
        const auto table = read_csv(folder.write("a.csv", "t_s,x\n0,1\n1,1\n" + time + ",1\n"), wanted);
        expect_in(refusal([&] { require_increasing(table); }), {"a.csv:4: ", "\"t_s\"", time + " follows 1"});
    }
}

}  // namespace
}  // namespace shaker::footage
