#include "perp/solve/problem_io.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "perp/solve/numerics_matrix.hpp"

using namespace perp;

namespace {

Matrix matrix_of(const std::string& text) {
  TextReader reader(text);
  return Matrix(read_numerics_matrix(reader));
}

// "LINE:COLUMN" of the error that reading the text as a matrix ends with, and its message.
struct Place {
  std::string at, message;
};

template <class Read>
Place error_of(Read read) {
  try {
    read();
  } catch (const ParseError& error) {
    return {std::to_string(error.line()) + ":" + std::to_string(error.column()), error.what()};
  }
  return {"no error", ""};
}

Place matrix_error(const std::string& text) {
  return error_of([&] { matrix_of(text); });
}

}  // namespace

TEST_CASE("dense storage is read column by column, however its lines are broken", "[io]") {
  Matrix expected(2, 3);
  expected << 1, 3, 5, 2, 4, 6.5e-3;
  CHECK(matrix_of("0\n2\n3\n2\t3\n1 2 3\n4 5 6.5e-3\n") == expected);
  CHECK(matrix_of("0 2 3 2 3 +1 2.0 3. 4 5e0 .0065") == expected);
}

TEST_CASE("blocks are put where the row pointer and the columns say, equal places summed", "[io]") {
  // Rows 2 + 1, columns 2 + 2: blocks (0, 1), (0, 1) again, and (1, 0).
  Matrix expected(3, 4);
  expected << 0, 0, 1 + 10, 3, 0, 0, 2, 4, 7, 8, 0, 0;
  const std::string head = "1\n3\n4\n3\n2\n2\n2 3\n2 4\n3\n3\n0 2 3\n1 1 0\n";
  CHECK(matrix_of(head + "0\n1 2 3 4\n1\n10 0 0 0\n2\n7 8") == expected);
  CHECK(matrix_error(head + "0\n1 2 3 4\n2\n10 0 0 0\n2\n7 8").at == "15:1");
  CHECK(matrix_error("1 3 4 3 2 2 2 4").at == "1:15");      // a block row ends past the matrix
  CHECK(matrix_error("1 3 4 3 2 2 2 3 2 3").at == "1:19");  // the last column is in no block
  CHECK(matrix_error("1 3 4 3 2 2 2 3 2 4 3 3 0 2 3 1 2 0").at == "1:33");  // no such block column
}

TEST_CASE("sparse text is read as triplets, by columns, by rows and as a symmetric half", "[io]") {
  Matrix expected(2, 3);
  expected << 0, 1, 2, 3, 0, 0;
  const std::string text = "\nCSparse Version 9, text\n";
  CHECK(matrix_of("2\n2\n3\n1" + text +
                  "triplet: 2-by-3, nzmax: 9 nnz: 3\n  0 1 : 1\n 0 2 : 2\n 1 0 : 3\n") == expected);
  CHECK(matrix_of("2\n2\n3\n2" + text +
                  "2-by-3, nzmax: 3 nnz: 3, 1-norm: 3\n col 0 : locations 0 to 0\n 1 : 3\n"
                  " col 1 : locations 1 to 1\n 0 : 1\n col 2 : locations 2 to 2\n 0 : 2\n") == expected);
  CHECK(matrix_of("2\n2\n3\n3" + text +
                  "2-by-3, nzmax: 3 nnz: 3, 1-norm: 3\n col 0 : locations 0 to 1\n 1 : 1\n 2 : 2\n"
                  " col 1 : locations 2 to 2\n 0 : 3\n") == expected);
  Matrix symmetric(2, 2);
  symmetric << 1, 5, 5, 0;
  CHECK(matrix_of("2\n2\n2\n4" + text + "triplet: 2-by-2, nzmax: 2 nnz: 2\n 0 0 : 1\n 1 0 : 5\n") ==
        symmetric);
  CHECK(matrix_of("2\n3\n0\n2" + text + "3-by-0, nzmax: 1 nnz: 0, 1-norm: 0\n").rows() == 3);
}

TEST_CASE("a column without entries and the numbers after the matrix are read as what they are", "[io]") {
  TextReader reader(
      "2 2 2 2\nfree text, 3 4 5\n2-by-2, nzmax: 1 nnz: 1, 1-norm: 7\n col 0 : locations 0 to -1\n"
      " col 1 : locations 0 to 0\n  0 : 7\n8 9");
  CHECK(Matrix(read_numerics_matrix(reader)) == (Matrix(2, 2) << 0, 7, 0, 0).finished());
  CHECK(reader.reals(2, "entry") == Vector2(8, 9));
  CHECK(reader.at_end());
}

TEST_CASE("an error names file, line and column, what was found and what is allowed", "[io]") {
  TextReader reader("0\n2 2\n2 2\n1 2\n  3 4x", "here.dat");
  const Place error = error_of([&] { (void)read_numerics_matrix(reader); });
  CHECK(error.message == "here.dat:5:5: matrix entry is \"4x\", a finite number is needed");
  CHECK(matrix_error("7 2 2").at == "1:1");
  CHECK(matrix_error("0 2 2\n2 3").at == "2:3");
  CHECK(matrix_error("0 1 1\n1 1\nnan").at == "3:1");
  CHECK(matrix_error("0 1 1\n1 1\n1e999").at == "3:1");
  CHECK(matrix_error("0 1 2\n1 2\n1\n").at == "4:1");  // the text ends
  CHECK(matrix_error("0 1.5 2").at == "1:3");
  CHECK(matrix_error("0 2000000000 1").at == "1:3");
  CHECK(matrix_error("2 1 1 1\ntext\ntriplet: 2-by-1, nzmax: 1 nnz: 1\n0 0 : 1").at == "3:10");
  CHECK(matrix_error("2 1 1 1\ntext\ntriplet: 1-by-1, nzmax: 1 nnz: 1\n0 1 : 1").at == "4:3");
  CHECK(matrix_error("2 1 1 1\ntext\ntriplet: 1-by-1, nzmax: 1 nnz: 1\n0 0 = 1").at == "4:5");
  CHECK(matrix_error("2 1 1 2\ntext\n1-by-1, nzmax: 1 nnz: 1 1-norm: 1").at == "3:23");
  CHECK(
      matrix_error("2 1 1 2\ntext\n1-by-1, nzmax: 1 nnz: 2, 1-norm: 1\ncol 0 : locations 0 to 0\n0 : 1").at ==
      "5:5");
  TextReader square("0 2 2");
  CHECK(error_of([&] { (void)read_numerics_matrix(square, 3, 3); }).at == "1:3");
}

TEST_CASE("an LCP file is n, A and b; what follows is not read", "[io]") {
  const Lcp lcp = read_lcp(TextReader("2\n0\n2\n2\n2\t2\n1 2\n3 4\n-5 -6\nA remark of 2 words"));
  CHECK(lcp.A == (Matrix(2, 2) << 1, 3, 2, 4).finished());
  CHECK(lcp.b == Vector2(-5, -6));
  CHECK(error_of([] { (void)read_lcp(TextReader("2\n0\n2\n2\n2 2\n1 2 3 4\n-5")); }).at == "7:3");
  CHECK(error_of([] { (void)read_lcp(TextReader("2\n0\n3 3\n3 3")); }).at == "3:1");
}

TEST_CASE("a mixed LCP file is read from the whole matrix, its blocks in any order, or from its parts",
          "[io]") {
  // Rows 0 and 2 are pairs, row 1 an equation.
  const std::string whole = "1 0\n1\n2\n0 1 2 3\n1 0 1\n0 3 3\n3 3\n1 2 3\n4 5 6\n7 8 9\n10 11 12\n";
  const MixedLcp p = read_mixed_lcp(TextReader(whole));
  CHECK(p.A == Matrix::Constant(1, 1, 5));
  CHECK(p.C == Eigen::RowVector2d(2, 8));
  CHECK(p.D == Vector2(4, 6));
  CHECK(p.B == (Matrix(2, 2) << 1, 7, 3, 9).finished());
  CHECK(p.a == Vector::Constant(1, 11));
  CHECK(p.b == Vector2(10, 12));

  const MixedLcp q = read_mixed_lcp(TextReader("0 1\n1\n2\n5\n1 7 3 9\n2 8\n4 6\n11\n10 12"));
  CHECK((q.A == p.A && q.B == p.B && q.C == p.C && q.D == p.D && q.a == p.a && q.b == p.b));

  const auto at = [](const char* text) {
    return error_of([=] { (void)read_mixed_lcp(TextReader(text)); }).at;
  };
  CHECK(at("0 0 1 2") == "1:3");
  CHECK(at("1 0 1 2\n1 3") == "2:1");
  CHECK(at("1 0 1 2\n0 1 4") == "2:5");
  CHECK(at("1 0 1 2\n0 1 3\n0 2") == "3:3");
  CHECK(at("1 0 1 2\n0 1 3\n0 0") == "3:3");
}

TEST_CASE("files are read, and a file that is not there is named", "[io]") {
  const std::string path = (std::filesystem::temp_directory_path() / "perp_problem_io_test.dat").string();
  std::ofstream(path) << "1\n0\n1\n1\n1 1\n2.5\n-1.25\n";
  CHECK(read_lcp(path).A(0, 0) == 2.5);
  std::ofstream(path) << "1\n0\n1\n1\n1 1\n2,5\n-1.25\n";
  const Place error = error_of([&] { (void)read_lcp(path); });
  CHECK(error.message == path + ":6:1: matrix entry is \"2,5\", a finite number is needed");
  std::filesystem::remove(path);
  CHECK_THROWS_WITH(read_lcp(path), Catch::Contains(path));
  CHECK_THROWS_AS(read_lcp(path), std::invalid_argument);
}
