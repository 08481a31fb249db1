#pragma once
// Answers of queries, written as required by IEEE 488.2 chapter 8 and the session's FORMat.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace shaker::scpi {

/// FORMat[:DATA] and FORMat:BORDer of one session.
struct Format {
    enum class Data { ascii, real32, real64 };
    Data data = Data::ascii;
    bool swapped = false;  // blocks of numbers are little-endian
};

/// The values of one query, separated by commas, after the earlier answers of the message. Grows to `limit`
/// bytes; bytes beyond are dropped and overflown() is true.
class Reply {
public:
    Reply(std::string& out, Format format, std::size_t limit);

    /// NR3 with 9 significant digits, with 17 in REAL,64. NaN is 9.91E37, infinities are 9.9E37 and -9.9E37.
    void number(double value);
    void integer(std::int64_t value);
    void boolean(bool value) { integer(value ? 1 : 0); }
    /// Character data, without quotes: for fixed words only, never for text from outside.
    void word(std::string_view text);
    /// In quotes, with quotes doubled; bytes that are not printable ASCII become \xNN.
    void string(std::string_view text);
    void block(std::string_view bytes);
    /// ASCii: numbers separated by commas. REAL: one block of 4 or 8 bytes per number.
    void numbers(std::span<const double> values);

    [[nodiscard]] bool overflown() const noexcept { return overflown_; }
    [[nodiscard]] bool empty() const noexcept { return empty_; }

private:
    void begin();
    void put(std::string_view text);
    void put_block_head(std::size_t length);

    std::string& out_;
    Format format_;
    std::size_t limit_;
    bool empty_ = true;
    bool overflown_ = false;
};

}  // namespace shaker::scpi
