import cProfile,pstats,sys
sys.argv=['ver','uc3','7.5,8,7','150','[1,2]']
src=open('wip/ver.py').read().replace("for kind in (0,1):","for kind in (0,):").replace("for s in (16,17,19):","for s in (19,):")
cProfile.run(compile(src,'ver','exec'),'/tmp/p/prof')
pstats.Stats('/tmp/p/prof').sort_stats('tottime').print_stats(22)
