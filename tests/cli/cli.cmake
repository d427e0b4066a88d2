# The tool as its users run it, and the Khronos validator over what it writes.
billow_add_executable(billow_test_files ${CMAKE_CURRENT_LIST_DIR}/make_files.cpp)
set_target_properties(billow_test_files PROPERTIES BILLOW_IS_TEST ON)
set(folder ${PROJECT_BINARY_DIR}/cli)
add_test(NAME cli.runs
    COMMAND ${CMAKE_COMMAND} -DBILLOW=$<TARGET_FILE:billow_cli>
            -DMAKE_FILES=$<TARGET_FILE:billow_test_files> -DFOLDER=${folder}
            -P ${CMAKE_CURRENT_LIST_DIR}/run.cmake)
set_tests_properties(cli.runs PROPERTIES LABELS cli TIMEOUT 600 FIXTURES_SETUP cli_files)

# The parts that the tool chooses when it runs, against those of the library.
billow_add_executable(billow_test_chosen ${CMAKE_CURRENT_LIST_DIR}/chosen.cpp)
target_include_directories(billow_test_chosen PRIVATE ${PROJECT_SOURCE_DIR}/examples/cli)
set_target_properties(billow_test_chosen PROPERTIES BILLOW_IS_TEST ON)
add_test(NAME cli.chosen COMMAND billow_test_chosen)
set_tests_properties(cli.chosen PROPERTIES LABELS cli TIMEOUT 120)

set(clouds)
foreach(name cube_cloud teapot_cloud leaves_cloud few empty_cloud "one face_cloud" degenerate_cloud
        square_cloud cube teapot leaves tree kept_trunk teapot_LOD0 teapot_LOD1 teapot_LOD2 textures_out forest/forest)
    list(APPEND clouds ${folder}/${name}.glb)
endforeach()
billow_add_validator_test(clouds FILES ${clouds} FIXTURE cli_files)

# Pages of the verb compare.
include(report/report.cmake)
set(pages)
foreach(name two_clouds odd_name no_planes)
    list(APPEND pages ${folder}/${name}.html)
endforeach()
billow_add_report_test(compare FILES ${pages} FIXTURE cli_files)
