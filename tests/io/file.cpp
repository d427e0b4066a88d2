#include <doctest/doctest.h>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;

TEST_SUITE("io/file") {
    TEST_CASE("what was written is read back, and nothing lies beside it") {
        const scratch::folder at;
        const std::vector<std::uint8_t> bytes{0, 13, 10, 255, 26};
        REQUIRE(write_file(at / "a.bin", bytes));
        REQUIRE(write_file(at / "a.bin", bytes));  // over itself
        const auto read = read_file(at / "a.bin");
        REQUIRE(read);
        CHECK(*read == bytes);
        CHECK(at.file_count() == 1);
    }

    TEST_CASE("files that cannot be read say why") {
        const scratch::folder at;
        CHECK(failed(read_file(at / "none"), error_code::not_found, "no such file", "none"));
        CHECK(failed(read_file(at / ""), error_code::not_found, "folder", ""));
        std::ofstream(at / "empty").close();
        CHECK(failed(read_file(at / "empty"), error_code::malformed, "empty", "empty"));
        at.put("large", "12345");
        CHECK(failed(read_file(at / "large", 4), error_code::too_large, "5 bytes", "large"));
    }

    TEST_CASE("an output that cannot be written is known before the work, and leaves nothing") {
        const scratch::folder at;
        CHECK(check_writable(at / "fine.glb"));
        CHECK(at.file_count() == 0);
        CHECK(failed(check_writable(at / "no" / "such.glb"), error_code::unwritable, "folder",
                     "such.glb"));
        std::filesystem::create_directory(at / "folder.glb");
        CHECK(failed(check_writable(at / "folder.glb"), error_code::unwritable, "folder",
                     "folder.glb"));
        CHECK_FALSE(write_file(at / "folder.glb", {}));
        CHECK_FALSE(write_file(at / "no" / "such.glb", {}));
        at.put("kept.glb", "old");
        CHECK(check_writable(at / "kept.glb"));
        CHECK(read_file(at / "kept.glb")->size() == 3);
        std::filesystem::permissions(at / "kept.glb", std::filesystem::perms::owner_read);
        CHECK(failed(check_writable(at / "kept.glb"), error_code::unwritable, "protected",
                     "kept.glb"));
        CHECK(at.file_count() == 2);
    }

    TEST_CASE("a link keeps pointing to the file that is written") {
        const scratch::folder at;
        at.put("real", "old");
        std::filesystem::create_symlink(at / "real", at / "link");
        at.put("link", "newer");
        CHECK(std::filesystem::is_symlink(at / "link"));
        CHECK(read_file(at / "real")->size() == 5);
    }

    TEST_CASE("names within files stay within the folder") {
        CHECK(*file_beside("models", "a/../b.png") == std::filesystem::path("models/b.png"));
        for (const char* name : {"../a.png", "a/../../b", "/etc/passwd", "", "..", "a/../.."}) {
            CHECK_FALSE(file_beside("models", name));
        }
    }

    TEST_CASE("messages are one line whatever a file is called") {
        const auto e = detail::file_error(error_code::malformed, "a\nb", "x\r\n\ty\n");
        CHECK(e.message == "a b: x y");
    }
}
