# The Khronos glTF validator as a test. Without node and npm, or without a network to install the
# validator from, the tests are skipped; in CI that is a failure.

# billow_add_validator_test(<name> FILES <file>... [FIXTURE <fixture>])
#
# Adds the test validator.<name>: zero errors and zero warnings in every file. The tests that set
# up <fixture> write the files.
function(billow_add_validator_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "FIXTURE" "FILES")
    add_test(NAME validator.${name}
        COMMAND ${CMAKE_COMMAND} "-DFILES=${arg_FILES}"
                -DFOLDER=${PROJECT_BINARY_DIR}/validator
                -P ${PROJECT_SOURCE_DIR}/tests/validator/run.cmake)
    set_tests_properties(validator.${name} PROPERTIES
        LABELS validator TIMEOUT 600 SKIP_REGULAR_EXPRESSION "validator is skipped"
        RESOURCE_LOCK billow_validator FIXTURES_REQUIRED "${arg_FIXTURE}")
endfunction()

# The gate itself: it lets a good file pass and stops a bad one.
file(CONFIGURE OUTPUT validator/good.gltf CONTENT "{\"asset\": {\"version\": \"2.0\"}}\n")
file(CONFIGURE OUTPUT validator/bad.gltf CONTENT "{\"asset\": {}}\n")
billow_add_validator_test(passes_a_good_file FILES ${CMAKE_CURRENT_BINARY_DIR}/validator/good.gltf)
billow_add_validator_test(stops_a_bad_file FILES ${CMAKE_CURRENT_BINARY_DIR}/validator/bad.gltf)
set_tests_properties(validator.stops_a_bad_file PROPERTIES WILL_FAIL ON)
