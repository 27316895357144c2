#include "view/browser.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

extern char** environ;

namespace perp {
namespace {

namespace fs = std::filesystem;

/// A folder for the browser's own files, gone with it.
class UserFolder {
 public:
  UserFolder() {
    std::string name = (fs::temp_directory_path() / "perp-view-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("a temporary folder could not be made");
    path_ = name;
  }
  ~UserFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  UserFolder(const UserFolder&) = delete;
  UserFolder& operator=(const UserFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string url_of(const fs::path& page, const std::string& fragment) {
  static constexpr char digits[] = "0123456789ABCDEF";
  std::string url = "file://";
  for (const char c : fs::absolute(page).string()) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u) || c == '/' || c == '-' || c == '_' || c == '.' || c == '~')
      url += c;
    else
      url += {'%', digits[u >> 4], digits[u & 15]};
  }
  return fragment.empty() ? url : url + "#" + fragment;
}

/// Runs the browser on a page; what it printed goes into the files `out` and `err`.
void run(const std::string& browser, const UserFolder& profile, std::vector<std::string> arguments, int width,
         int height, const fs::path& out, const fs::path& err) {
  std::vector<std::string> all{browser,
                               "--headless",
                               "--disable-gpu",
                               "--enable-unsafe-swiftshader",
                               "--no-first-run",
                               "--disable-background-networking",
                               "--disable-component-update",
                               "--disable-sync",
                               "--disable-quic",
                               "--hide-scrollbars",
                               "--host-resolver-rules=MAP * ~NOTFOUND",
                               "--user-data-dir=" + profile.path().string(),
                               "--virtual-time-budget=10000",
                               "--window-size=" + std::to_string(width) + "," + std::to_string(height)};
  if (geteuid() == 0) all.emplace_back("--no-sandbox");  // it refuses to run as root otherwise
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& a : all) argv.push_back(a.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = 0;
  const int failed = posix_spawn(&child, browser.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error(browser + " could not be started");
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace

std::string find_browser() {
  const char* path = std::getenv("PATH");
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    std::istringstream folders(path == nullptr ? "/usr/bin" : path);
    for (std::string folder; std::getline(folders, folder, ':');)
      if (const fs::path file = fs::path(folder) / name; access(file.c_str(), X_OK) == 0)
        return file.string();
  }
  return {};
}

void take_picture(const std::string& browser, const fs::path& page, const std::string& fragment, int width,
                  int height, const fs::path& png) {
  const UserFolder profile;
  const fs::path out = profile.path() / "out", err = profile.path() / "err",
                 shot = profile.path() / "shot.png";
  run(browser, profile, {"--screenshot=" + shot.string(), url_of(page, fragment)}, width, height, out, err);
  std::error_code failed;
  fs::copy_file(shot, png, fs::copy_options::overwrite_existing, failed);
  if (failed)
    throw std::runtime_error("no picture " + png.string() + " came of " + browser + ": " +
                             text_of(err).substr(0, 2000));
}

std::string document_of(const std::string& browser, const fs::path& page, const std::string& fragment,
                        int width, int height) {
  const UserFolder profile;
  const fs::path out = profile.path() / "out", err = profile.path() / "err";
  run(browser, profile, {"--dump-dom", url_of(page, fragment)}, width, height, out, err);
  std::string document = text_of(out);
  if (document.empty())
    throw std::runtime_error(browser + " gave no document: " + text_of(err).substr(0, 2000));
  return document;
}

}  // namespace perp
