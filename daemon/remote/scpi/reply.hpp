#pragma once
// What queries answer, written as IEEE 488.2 chapter 8 and the session's FORMat have it.
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

/// The values of one query, commas between them, behind what the message has answered so far. It grows to
/// `limit` bytes; what is beyond is not kept and overflown() says so.
class Reply {
public:
    Reply(std::string& out, Format format, std::size_t limit);

    /// NR3 with 9 significant digits, with 17 in REAL,64. NaN is 9.91E37, the infinities are 9.9E37 and
    /// -9.9E37.
    void number(double value);
    void integer(std::int64_t value);
    void boolean(bool value) { integer(value ? 1 : 0); }
    /// Character data, without quotes: the caller's own words only.
    void word(std::string_view text);
    /// In quotes, doubled inside; bytes that are not printable ASCII read \xNN.
    void string(std::string_view text);
    void block(std::string_view bytes);
    /// Commas between numbers in ASCii; one block of 4 or 8 bytes each in REAL.
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
