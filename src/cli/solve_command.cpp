// perp solve: problems in files, one after the other, each with how its solve ended and how good the answer is.
#include <unistd.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <Eigen/LU>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/csv_file.hpp"
#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/solve/lemke.hpp"
#include "perp/solve/problem_io.hpp"

namespace perp {
namespace {

struct SolveRequest {
  double tolerance = 1e-10;  // of the relative residual: the pass mark
  std::string solver = "chain";
  std::string solutions;  // folder, or empty: none are written
};

// A row of the report. A number that a kind of problem does not have is NaN.
struct Answer {
  std::string status = "bad-file", stage;
  double contacts = not_set, rank = not_set, iterations = not_set;
  double residual_absolute = not_set, residual_relative = not_set, residual_file = not_set;
  double seconds = not_set;  // of the solve, without reading
  std::string existence{};   // of a solution: exists, none, unknown
};

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

std::filesystem::path solution_path(const SolveRequest& request, const std::string& file) {
  std::filesystem::create_directories(request.solutions);
  return std::filesystem::path(request.solutions) / std::filesystem::path(file).filename().concat(".csv");
}

std::string status_of(LcpStatus status, double residual, double tolerance) {
  if (status == LcpStatus::NoSolution || status == LcpStatus::Exhausted) return "no-solution";
  return residual <= tolerance ? "solved" : "best-found";
}

void need_solver(const SolveRequest& request, const char* kind, std::initializer_list<const char*> known) {
  if (std::find(known.begin(), known.end(), request.solver) != known.end()) return;
  std::string need = std::string("a file of the kind ") + kind + " needs one of:";
  for (const char* name : known) need.append(" ").append(name);
  refuse("perp solve", "--solver", request.solver, need);
}

Answer solve_lcp_file(const std::string& file, const SolveRequest& request) {
  need_solver(request, "lcp", {"chain", "lemke"});
  const Lcp lcp = read_lcp(file);
  const Stopwatch watch;
  const LcpSolution solution = request.solver == "lemke" ? lemke(lcp) : solve_lcp(lcp);
  Answer answer{.stage = std::string(solution.stage), .seconds = watch.seconds()};
  answer.rank = static_cast<double>(Eigen::FullPivLU<Matrix>(lcp.A).rank());
  answer.iterations = solution.pivots;
  answer.residual_absolute = answer.residual_file = solution.residual;
  answer.residual_relative = lcp_relative_residual(lcp.A, lcp.b, solution.z);
  answer.status = status_of(solution.status, answer.residual_relative, request.tolerance);
  if (!request.solutions.empty()) {
    const Vector w = lcp.A * solution.z + lcp.b;
    CsvFile csv(solution_path(request, file), {"row", "z", "w"});
    for (int i = 0; i < static_cast<int>(w.size()); ++i) csv.cell(i).cell(solution.z[i]).cell(w[i]).end_row();
    csv.finish();
  }
  return answer;
}

Answer solve_mixed_lcp_file(const std::string& file, const SolveRequest& request) {
  need_solver(request, "mlcp", {"chain"});
  const MixedLcp problem = read_mixed_lcp(file);
  const Stopwatch watch;
  const MixedLcpSolution solution = solve_mixed_lcp(problem);
  Answer answer{.stage = std::string(solution.stage), .seconds = watch.seconds()};
  answer.rank = static_cast<double>(Eigen::FullPivLU<Matrix>(problem.A).rank());
  answer.iterations = solution.pivots;
  answer.residual_absolute = answer.residual_file = solution.residual;
  answer.residual_relative = mixed_lcp_relative_residual(problem, solution.u, solution.v);
  answer.status = status_of(solution.status, answer.residual_relative, request.tolerance);
  if (!request.solutions.empty()) {
    const Vector w = problem.D * solution.u + problem.B * solution.v + problem.b;
    CsvFile csv(solution_path(request, file), {"variable", "row", "value", "w"});
    for (int i = 0; i < static_cast<int>(solution.u.size()); ++i)
      csv.cell("u").cell(i).cell(solution.u[i]).cell(not_set).end_row();
    for (int i = 0; i < static_cast<int>(w.size()); ++i)
      csv.cell("v").cell(i).cell(solution.v[i]).cell(w[i]).end_row();
    csv.finish();
  }
  return answer;
}

FrictionMethod friction_method(const std::string& solver) {
  if (solver == "newton") return FrictionMethod::Newton;
  if (solver == "interior-point") return FrictionMethod::InteriorPoint;
  if (solver == "proximal") return FrictionMethod::Proximal;
  if (solver == "gauss-seidel") return FrictionMethod::GaussSeidel;
  if (solver == "ipopt") return FrictionMethod::Ipopt;
  return FrictionMethod::Chain;
}

// Normal and tangential rows, 0 where a block has none, then the moments' rows where any block has some.
void write_friction_solution(const std::filesystem::path& path, const FrictionProblem& problem,
                             const FrictionSolution& solution) {
  using Moments = std::vector<std::pair<const char*, int>>;  // name, rows after the tangential ones
  const auto moments_of = [](BlockKind kind) -> Moments {
    if (kind == BlockKind::Torsional) return {{"torsion", 3}};
    if (kind == BlockKind::Rolling) return {{"rolling1", 3}, {"rolling2", 4}};
    if (kind == BlockKind::TorsionalRolling) return {{"torsion", 3}, {"rolling1", 4}, {"rolling2", 5}};
    if (kind == BlockKind::PlanarRolling) return {{"rolling1", 2}};
    return {};
  };
  const Moments moments =
      problem.blocks() > 0 ? moments_of(problem.kind(0)) : Moments{};  // files have one kind
  std::vector<std::string> header{"contact", "rn", "rt1", "rt2", "un", "ut1", "ut2"};
  for (const char* side : {"r_", "u_"})
    for (const auto& [name, row] : moments) header.push_back(std::string(side) + name);
  CsvFile csv(path, header);
  const std::vector<Eigen::Index> first = problem.offsets();
  for (int i = 0; i < static_cast<int>(problem.blocks()); ++i) {
    const Eigen::Index tangents = first[i + 1] - first[i] - static_cast<Eigen::Index>(moments.size());
    csv.cell(i);
    for (const Vector& x : {solution.r, solution.u})
      for (Eigen::Index k = 0; k < 3; ++k) csv.cell(k < tangents ? x(first[i] + k) : 0.0);
    for (const Vector& x : {solution.r, solution.u})
      for (const auto& [name, row] : moments) csv.cell(x(first[i] + row));
    csv.end_row();
  }
  csv.finish();
}

Answer solve_friction_file(const std::string& file, const SolveRequest& request) {
  need_solver(request, "friction",
              {"chain", "newton", "interior-point", "proximal", "gauss-seidel", "ipopt"});
  if (request.solver == "ipopt" && !has_ipopt())
    refuse("perp solve", "--solver", request.solver, "this perp was built without Ipopt");
  std::vector<std::string> remarks;
  const FrictionProblem problem = read_friction_problem(file, &remarks);
  for (const std::string& remark : remarks)
    std::fprintf(stderr, "perp: %s: note: %s\n", file.c_str(), remark.c_str());
  const Stopwatch watch;
  const FrictionSolution solution =
      solve_friction(problem, {.tolerance = request.tolerance, .method = friction_method(request.solver)});
  Answer answer{.status = std::string(to_string(solution.status)),
                .stage = std::string(to_string(solution.stage)),
                .seconds = watch.seconds()};
  constexpr Eigen::Index most_rows = 400;  // of a dense rank; above it the column stays empty
  if (problem.rows() <= most_rows)
    answer.rank = static_cast<double>(to_local(problem).W.to_dense().fullPivLu().rank());
  answer.existence = to_string(solution.existence);
  answer.contacts = static_cast<double>(problem.blocks());
  answer.iterations = solution.iterations;
  answer.residual_absolute = solution.residuals.absolute;
  answer.residual_relative = solution.residuals.relative;
  answer.residual_file = solution.residuals.file;
  if (!request.solutions.empty()) write_friction_solution(solution_path(request, file), problem, solution);
  return answer;
}

// What a file's first whole numbers look like says which kinds it may be of where the command line does not.
using Beginning = std::vector<int>;

Beginning beginning_of(const std::string& file) {
  TextReader reader = TextReader::from_file(file);
  Beginning numbers;
  while (numbers.size() < 6 && !reader.at_end()) {
    const std::string_view token = reader.word("number");
    int value = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc() || end != token.data() + token.size()) break;
    numbers.push_back(value);
  }
  return numbers;
}

bool is_storage(int number) { return 0 <= number && number <= 2; }

// n, then a storage and the shape (n, n), dense storage says the shape twice; or n, A, b as they are.
bool looks_like_lcp(const Beginning& x, const std::string& file) {
  return (x.size() >= 4 && is_storage(x[1]) && x[2] == x[0] && x[3] == x[0] &&
          (x[1] != 0 || (x.size() >= 6 && x[4] == x[0] && x[5] == x[0]))) ||
         (!x.empty() && is_plain_lcp(TextReader::from_file(file)));
}

// Two flags, n, m and the boundary 0.
bool looks_like_mixed_lcp(const Beginning& x, const std::string&) {
  return x.size() >= 5 && 0 <= x[0] && x[0] <= 1 && 0 <= x[1] && x[1] <= 1 && x[0] + x[1] > 0 &&
         (x[0] == 0 || x[4] == 0);
}

// 2 to 6 rows a contact, the contacts, then a storage.
bool looks_like_friction(const Beginning& x, const std::string&) {
  return x.size() >= 4 && 2 <= x[0] && x[0] <= 6 && x[1] >= 0 && is_storage(x[2]);
}

struct Kind {
  const char* name;
  bool (*looks_like)(const Beginning&, const std::string& file);
  void (*read)(const std::string& file);
  Answer (*solve)(const std::string& file, const SolveRequest&);
};

constexpr std::array kinds{
    Kind{"lcp", looks_like_lcp, [](const std::string& file) { (void)read_lcp(file); }, solve_lcp_file},
    Kind{"mlcp", looks_like_mixed_lcp, [](const std::string& file) { (void)read_mixed_lcp(file); },
         solve_mixed_lcp_file},
    Kind{"friction", looks_like_friction, [](const std::string& file) { (void)read_friction_problem(file); },
         solve_friction_file},
};

bool can_read(const Kind& kind, const std::string& file) {
  try {
    kind.read(file);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

// The kind whose first numbers a file has; of several the one as which all of it can be read.
const Kind& kind_of(const std::string& file, const std::string& named) {
  if (named.empty() && is_hdf5_file(file)) return kind_of(file, "friction");
  const Beginning beginning = named.empty() ? beginning_of(file) : Beginning{};
  std::vector<const Kind*> possible, readable;
  std::string names;
  for (const Kind& kind : kinds) {
    if (named.empty() ? kind.looks_like(beginning, file) : kind.name == named) possible.push_back(&kind);
    names.append(names.empty() ? "" : ", ").append(kind.name);
  }
  if (possible.size() == 1) return *possible.front();
  for (const Kind* kind : possible)
    if (can_read(*kind, file)) readable.push_back(kind);
  if (readable.size() == 1) return *readable.front();
  if (readable.size() > 1)
    throw ParseError(
        file, 1, 1,
        std::string("the file can be read as ") + readable[0]->name + " and as " + readable[1]->name,
        "--kind says which it is");
  if (!possible.empty()) return *possible.front();  // its reader says what is wrong
  throw ParseError(file, 1, 1, "the first numbers are of no known kind of problem", names + " can be read");
}

void print_csv(const std::string& file, const std::string& kind, const Answer& a) {
  std::string row = file.find_first_of(",\"\n") == std::string::npos ? file : "\"";
  if (row == "\"") {
    for (const char c : file) row.append(c == '"' ? 2 : 1, c);
    row += '"';
  }
  row.append(",").append(kind);
  const auto number = [&](double x) { row.append(",").append(x == x ? shortest(x) : ""); };
  number(a.contacts), number(a.rank);
  row.append(",").append(a.status).append(",").append(a.stage);
  number(a.iterations), number(a.residual_absolute), number(a.residual_relative), number(a.residual_file);
  number(a.seconds);
  row.append(",").append(a.existence);
  std::printf("%s\n", row.c_str());
}

void print_line(const std::string& file, const std::string& kind, const Answer& a) {
  std::printf("%s: %s %s", file.c_str(), kind.c_str(), a.status.c_str());
  if (!a.stage.empty())
    std::printf(" by %s, residual %s (relative %s), %s s", a.stage.c_str(),
                shortest(a.residual_absolute).c_str(), shortest(a.residual_relative).c_str(),
                shortest(a.seconds).c_str());
  if (a.status == "best-found" && a.existence == "exists") std::printf(", though a solution exists");
  std::printf("\n");
}

int solve_files(const std::vector<std::string>& files, const std::string& kind, const SolveRequest& request,
                bool csv) {
  if (csv)
    std::printf(
        "file,kind,contacts,rank,status,stage,iterations,residual_absolute,residual_relative,"
        "residual_file,seconds,existence\n");
  const bool terminal = isatty(STDERR_FILENO) != 0;  // there a line says which file is being solved
  int status = Done, begun = 0;
  for (const std::string& file : files) {
    Answer answer;
    std::string name = kind;
    if (terminal) std::fprintf(stderr, "[%d/%zu] %s", ++begun, files.size(), file.c_str());
    const auto wipe = [&] { std::fputs(terminal ? "\r\033[K" : "", stderr); };
    try {
      const Kind& found = kind_of(file, kind);
      name = found.name;
      answer = found.solve(file, request);
      status = std::max<int>(status, answer.status == "solved" ? Done : ToleranceNotReached);
      wipe();
    } catch (const std::invalid_argument& error) {
      wipe();
      std::fprintf(stderr, "perp: %s\n", error.what());
      status = std::max<int>(status, BadInput);
    } catch (const std::exception& error) {  // the other files are none of its business
      wipe();
      std::fprintf(stderr, "perp: %s: %s\n", file.c_str(), sentence_of(error).c_str());
      status = InternalError;
    }
    (csv ? print_csv : print_line)(file, name, answer);
    need_written(stdout);
  }
  return status;
}

}  // namespace

void add_solve_command(CLI::App& perp, int& status) {
  struct Arguments {
    std::vector<std::string> files;
    std::string kind;
    SolveRequest request;
    bool csv = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      perp.add_subcommand("solve", "Solve the problems in files: contacts with friction, LCPs, mixed LCPs");
  command->add_option("FILE", arguments->files, "Problem files")->required();
  std::vector<std::string> names;
  for (const Kind& kind : kinds) names.emplace_back(kind.name);
  command->add_option("--kind", arguments->kind, "What the files hold; found out from each if not given")
      ->check(CLI::IsMember(names));
  command->add_option("--tolerance", arguments->request.tolerance, "Pass mark of the relative residual")
      ->check(finite_number())
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--solver", arguments->request.solver, "chain; for LCPs also lemke")
      ->capture_default_str();
  command->add_flag("--csv", arguments->csv, "One CSV row a file instead of a line of text");
  command->add_option("--solutions", arguments->request.solutions,
                      "Folder for each file's solution, FILE.csv");
  command->callback([arguments, &status] {
    status = solve_files(arguments->files, arguments->kind, arguments->request, arguments->csv);
  });
}

}  // namespace perp
