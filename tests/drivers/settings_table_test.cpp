#include "drivers/settings_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

SettingsTable parse(std::string_view text) { return SettingsTable::from_text(text, "some/where.toml"); }

std::string refusal(const std::function<void()>& action) {
    try {
        action();
        return "accepted";
    } catch (const InputError& error) {
        return error.what();
    }
}

void expect_in(const std::string& message, std::initializer_list<std::string_view> parts) {
    for (const auto part : parts)
        EXPECT_NE(message.find(part), std::string::npos) << "\"" << part << "\" is not in: " << message;
}

TEST(SettingsTableTest, EveryKindOfValueIsRead) {
    auto table = parse(
        "x = 1.5\nwhole = 3\nname = \"top\"\non = true\naxis = [1, 0.5]\n"
        "words = [\"a\", \"b\"]\nkind = \"disc\"\n");
    EXPECT_EQ(table.number("x", {0, 2}), 1.5);
    EXPECT_EQ(table.number("whole", {0, 5}), 3.0);
    EXPECT_EQ(table.integer("whole", 0, 5, 9), 3);
    EXPECT_EQ(table.text("name"), "top");
    EXPECT_TRUE(table.flag("on", false));
    EXPECT_EQ(table.numbers("axis", 2), (std::vector<double>{1, 0.5}));
    EXPECT_EQ(table.texts("words", 2), (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(table.choice("kind", {"rectangle", "disc"}), 1U);
    EXPECT_TRUE(table.is_text("name"));
    EXPECT_FALSE(table.is_text("axis"));
    EXPECT_FALSE(table.is_text("nothing"));
    table.finish();
}

TEST(SettingsTableTest, QuantitiesAreNumbersOrTextsWithAUnit) {
    auto table = parse("a = \"1.5g\"\nb = 2\nlist = [3, \"50%\"]\nsets = [[], [{n = 1}, {n = 2}]]\n");
    EXPECT_DOUBLE_EQ(table.quantity("a", Dimension::acceleration, {0, 20}), 14.7);
    EXPECT_EQ(table.quantity("b", Dimension::time, {0, 5}, 1), 2);
    EXPECT_EQ(table.quantity("c", Dimension::time, {0, 5}, 1), 1);
    EXPECT_EQ(table.quantities("b", Dimension::time, {0, 5}), std::vector<double>{2});
    EXPECT_EQ(table.quantities("list", Dimension::ratio, {0, 5}), (std::vector<double>{3, 0.5}));
    auto sets = table.lists_of_tables("sets");
    ASSERT_EQ(sets.size(), 2U);
    EXPECT_TRUE(sets[0].empty());
    EXPECT_EQ(sets[1].at(1).integer("n", 0, 9, 0), 2);
    EXPECT_EQ(table.line("sets"), 4U);
    EXPECT_FALSE(table.is_table("list"));
    table.finish();
}

// A value of an array is on a line of its own.
TEST(SettingsTableTest, RefusalsInArraysNameTheLineOfTheValue) {
    auto table = parse("list = [\n  1,\n  \"7 apples\",\n]\nempty = []\n");
    expect_in(refusal([&] {
                  table.quantities("list", Dimension::ratio, {0, 9});
              }),
              {"some/where.toml:3: list \"7 apples\": unknown unit \"apples\""});
    expect_in(refusal([&] {
                  table.quantities("empty", Dimension::ratio, {0, 9});
              }),
              {"some/where.toml:5: empty: expected at least one quantity"});
    expect_in(refusal([&] { table.lists_of_tables("list"); }), {"some/where.toml:2: list: expected tables"});
}

TEST(SettingsTableTest, MissingKeysUseTheirDefault) {
    auto table = parse("");
    EXPECT_EQ(table.number("x", {0, 2}, 7), 7);
    EXPECT_EQ(table.integer("n", 0, 5, 9), 9);
    EXPECT_TRUE(table.flag("on", true));
    EXPECT_EQ(table.text("name", "none"), "none");
    EXPECT_EQ(table.choice("kind", {"a", "b"}, 1), 1U);
    EXPECT_FALSE(table.has("x"));
    EXPECT_EQ(table.table("sub").number("y", {0, 9}, 4), 4);
    EXPECT_TRUE(table.tables("list").empty());
    table.finish();
}

TEST(SettingsTableTest, AMissingKeyIsNamedWithItsTableAndLine) {
    auto table = parse("title = \"t\"\n\n[drive]\nrho = 0.5\n");
    auto drive = table.table("drive");
    expect_in(refusal([&] {
                  drive.number("frequency_hz", {0.1, 5000});
              }),
              {"some/where.toml:3: drive.frequency_hz: ", "missing", "0.1 to 5000"});
    expect_in(refusal([&] { drive.text("file"); }), {":3: drive.file: ", "missing"});
    expect_in(refusal([&] { drive.choice("kind", {"disc", "bars"}); }), {"drive.kind", "\"disc\", \"bars\""});
    auto absent = table.table("camera");
    expect_in(refusal([&] { absent.text("name"); }), {"some/where.toml:1: camera.name: "});
}

TEST(SettingsTableTest, RefusesWrongTypeWithLineAndValue) {
    auto table = parse("a = \"1.5\"\nb = 2\nc = [1, \"x\"]\nd = 1.5\ne = true\nf = {g = 1}\n");
    expect_in(refusal([&] {
                  table.number("a", {0, 2});
              }),
              {"some/where.toml:1: a: ", "1.5", "a number, 0 to 2"});
    expect_in(refusal([&] { table.text("b"); }), {":2: b: expected a string in quotes, got 2"});
    expect_in(refusal([&] { table.numbers("c", 2); }), {":3: c: ", "x", "a number"});
    expect_in(refusal([&] { table.numbers("c", 3); }), {":3: c: ", "an array of 3 numbers"});
    expect_in(refusal([&] { table.texts("c", 2); }), {":3: c: expected a string", "got 1"});
    expect_in(refusal([&] { table.integer("d", 0, 9, 1); }),
              {":4: d: expected a whole number, 0 to 9", "got 1.5"});
    expect_in(refusal([&] { table.number("e", {0, 1}, 0); }), {":5: e: ", "got true"});
    expect_in(refusal([&] { table.flag("b", false); }), {":2: b: expected true or false", "got 2"});
    expect_in(refusal([&] { table.text("f"); }), {":6: f: "});
    expect_in(refusal([&] { table.table("a"); }), {":1: a: ", "a table [a]"});
    expect_in(refusal([&] { table.tables("f"); }), {":6: f: ", "[[f]]"});
    expect_in(refusal([&] { table.tables("c"); }), {":3: c: "});
    expect_in(refusal([&] { table.choice("b", {"x"}); }), {":2: b: expected one of \"x\"", "got 2"});
}

TEST(SettingsTableTest, ValuesOutOfRangeAndNonFiniteOnesAreRefused) {
    auto table = parse("a = -3\nb = nan\nc = inf\nd = [0.0, nan]\ne = 99999999999\n");
    expect_in(refusal([&] { table.number("a", {0, 2}); }), {":1: a: expected a number, 0 to 2, got -3"});
    expect_in(refusal([&] { table.number("b", {-1e308, 1e308}); }), {":2: b: ", "got nan"});
    expect_in(refusal([&] { table.number("c", {0, INFINITY}); }), {":3: c: ", "at least 0", "got inf"});
    expect_in(refusal([&] { table.numbers("d", 2); }), {":4: d: ", "got nan"});
    expect_in(refusal([&] { table.integer("e", 0, 10, 0); }), {":5: e: ", "0 to 10", "got 99999999999"});
}

TEST(SettingsTableTest, AnUnknownKeyIsNamedWithTheNearestKnownOne) {
    auto table = parse("title = \"t\"\n[drive]\nfrequency_hz = 20\ngama_mps2 = 14.7\n");
    table.text("title", "");
    auto drive = table.table("drive");
    drive.number("frequency_hz", {0.1, 5000});
    drive.number("gamma_mps2", {0, 1000}, 0);
    expect_in(refusal([&] { drive.finish(); }), {"some/where.toml:4: drive.gama_mps2: ", "unknown key",
                                                 "did you mean \"gamma_mps2\"?", "\"frequency_hz\""});
    table.finish();
}

TEST(SettingsTableTest, SuggestsKeyWithMissingUnit) {
    auto table = parse("frequency = 20\n");
    table.number("frequency_hz", {0.1, 5000}, 20);
    expect_in(refusal([&] { table.finish(); }), {":1: frequency: ", "did you mean \"frequency_hz\"?"});
}

TEST(SettingsTableTest, TheFirstOfManyUnknownKeysIsNamed) {
    auto table = parse("zebra = 1\nknown = 2\nant = 3\n");
    table.number("known", {0, 5});
    const std::string message = refusal([&] { table.finish(); });
    expect_in(message, {":1: zebra", "(known: \"known\")"});
    EXPECT_EQ(message.find("did you mean"), std::string::npos) << message;
}

TEST(SettingsTableTest, ArraysOfTablesAreInOrderAndNested) {
    auto table = parse(
        "[[camera]]\nname = \"top\"\n[[camera.target]]\nname = \"walker\"\n[[camera.target]]\n"
        "name = \"base\"\nroi = 3\n[[camera]]\nname = \"side\"\n");
    auto cameras = table.tables("camera");
    ASSERT_EQ(cameras.size(), 2U);
    EXPECT_EQ(cameras[0].text("name"), "top");
    EXPECT_EQ(cameras[1].text("name"), "side");
    auto targets = cameras[0].tables("target");
    ASSERT_EQ(targets.size(), 2U);
    EXPECT_EQ(targets[1].text("name"), "base");
    expect_in(refusal([&] { targets[1].finish(); }), {"some/where.toml:7: camera.target.roi: "});
    expect_in(refusal([&] { targets[0].text("kind"); }), {"some/where.toml:3: camera.target.kind: "});
    EXPECT_TRUE(cameras[1].tables("target").empty());
}

TEST(SettingsTableTest, BrokenTomlIsReportedWithLineAndColumn) {
    expect_in(refusal([] { parse("a = 1\nb = = 2\n"); }), {"some/where.toml:2:5: "});
    expect_in(refusal([] { parse("a = 1\na = 2\n"); }), {"some/where.toml:2:"});
}

TEST(SettingsTableTest, ACallersOwnCheckFailsWithTheLineOfItsKey) {
    auto table = parse("a = 1\n[sub]\nb = 2\n");
    auto sub = table.table("sub");
    expect_in(refusal([&] { table.fail("a", "must not be 1"); }), {"some/where.toml:1: a: must not be 1"});
    expect_in(refusal([&] { sub.fail("b", "no"); }), {"some/where.toml:3: sub.b: no"});
    expect_in(refusal([&] { sub.fail("", "no"); }), {"some/where.toml:2: sub: no"});
    EXPECT_EQ(sub.folder(), std::filesystem::path{"some"});
}

TEST(SettingsTableTest, NamesMissingFile) {
    const auto folder = std::filesystem::path{::testing::TempDir()};
    expect_in(refusal([&] { SettingsTable::from_file(folder / "not_there.toml"); }),
              {"not_there.toml", "No such file"});
    expect_in(refusal([&] { SettingsTable::from_file(folder); }), {"is a folder"});
}

TEST(SettingsTableTest, AFileIsReadWithItsFolderAndAByteOrderMark) {
    const auto file = std::filesystem::path{::testing::TempDir()} / "settings_table_bom.toml";
    std::ofstream{file} << "\xEF\xBB\xBFx = 2\r\n";
    auto table = SettingsTable::from_file(file);
    EXPECT_EQ(table.number("x", {0, 5}), 2);
    EXPECT_EQ(table.folder(), file.parent_path());
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace shaker
