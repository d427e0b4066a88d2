# Pages that the tool writes, in headless Chromium. Without node, npm or Chromium, or without a network
# to install playwright-core from, the test is skipped; in CI that is a failure.

# billow_add_report_test(<name> FILES <file>... [FIXTURE <fixture>])
#
# Adds the test report.<name>: every page works. The tests that set up <fixture> write the files.
function(billow_add_report_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "FIXTURE" "FILES")
    add_test(NAME report.${name}
        COMMAND ${CMAKE_COMMAND} "-DFILES=${arg_FILES}" -DFOLDER=${PROJECT_BINARY_DIR}/report
                -P ${PROJECT_SOURCE_DIR}/tests/report/run.cmake)
    set_tests_properties(report.${name} PROPERTIES
        LABELS report TIMEOUT 300 SKIP_REGULAR_EXPRESSION "report is skipped"
        RESOURCE_LOCK billow_report FIXTURES_REQUIRED "${arg_FIXTURE}")
endfunction()

# The gate itself: it stops a page whose pictures do not decode.
file(CONFIGURE OUTPUT report/bad.html CONTENT
    "<!doctype html><title>bad</title><img alt=\"bad\" src=\"data:image/png;base64,AAAA\">\n")
billow_add_report_test(stops_a_bad_page FILES ${CMAKE_CURRENT_BINARY_DIR}/report/bad.html)
set_tests_properties(report.stops_a_bad_page PROPERTIES WILL_FAIL ON)
